from .neighbors import MOMENTS_MAX as MOMENTS_MAX
from .neighbors import Moment as Moment
from .neighbors import Neighbors as Neighbors
from .neighbors import Table as Table
from .neighbors import learn_numbers as learn_numbers
