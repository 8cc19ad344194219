from . import supervision as supervision
