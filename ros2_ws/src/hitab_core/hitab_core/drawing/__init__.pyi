from . import graph as graph
from . import layout as layout
from . import picture as picture
