from . import angles as angles
from . import arranging as arranging
from . import interception as interception
from . import kicking as kicking
from . import physics as physics
from . import referee as referee
from . import rules as rules
from . import takers as takers
