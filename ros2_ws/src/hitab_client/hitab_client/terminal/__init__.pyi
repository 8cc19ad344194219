from . import cli_options as cli_options
from . import cli_remedies as cli_remedies
from . import completion as completion
from . import console as console
from . import interruptions as interruptions
