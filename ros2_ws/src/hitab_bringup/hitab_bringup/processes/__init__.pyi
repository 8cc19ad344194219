from . import leases as leases
from . import supervision as supervision
