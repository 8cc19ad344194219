from . import checks as checks
from . import conversions as conversions
from . import plain_text as plain_text
from . import stamps as stamps
