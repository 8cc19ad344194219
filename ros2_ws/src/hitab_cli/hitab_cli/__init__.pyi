from .verbs.libraries.library_options import Library as Library
from .verbs.libraries.library_options import opened as opened
from .verbs.libraries.library_options import write_new as write_new
from .verbs.train.driving_verbs import FirstAgent as FirstAgent
from .verbs.train.driving_verbs import carry_out as carry_out
from .verbs.train.driving_verbs import demonstrator_of as demonstrator_of
from .verbs.verb_connection import connection as connection
