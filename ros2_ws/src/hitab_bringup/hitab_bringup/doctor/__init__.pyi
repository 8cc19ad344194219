from . import machine as machine
from . import ros as ros
from . import runs as runs
from .finding import ERROR as ERROR
from .finding import WARNING as WARNING
from .finding import Finding as Finding
from .finding import judged as judged
