from . import commander_domain as commander_domain
from .kind import CommanderKind as CommanderKind
from .kind import OrderMap as OrderMap
from .kind_reader import KIND_FILE as KIND_FILE
from .kind_reader import parse_kind as parse_kind
from .kind_reader import read_kind as read_kind
from .kind_writer import kind_text as kind_text
