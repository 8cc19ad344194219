from . import checks as checks
from . import conversions as conversions
from . import cycle_codec as cycle_codec
from . import pieces as pieces
from . import plain_text as plain_text
from . import stamps as stamps
