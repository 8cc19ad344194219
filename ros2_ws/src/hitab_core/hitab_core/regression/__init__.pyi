from .neighbors import MOMENTS_MAX as MOMENTS_MAX
from .neighbors import Neighbors as Neighbors
from .neighbors import NumberExample as NumberExample
from .neighbors import NumberTable as NumberTable
from .neighbors import learn_numbers as learn_numbers
