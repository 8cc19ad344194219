from . import diagnostics as diagnostics
from . import exit_codes as exit_codes
from . import fault_texts as fault_texts
from . import faults as faults
