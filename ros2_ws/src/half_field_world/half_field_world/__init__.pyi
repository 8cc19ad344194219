from . import game as game
from . import parameters as parameters
