from .generations import LENGTH as LENGTH
from .generations import Generation as Generation
from .generations import Generations as Generations
from .generations import folder_of as folder_of
from .generations import read_generations as read_generations
from .steps import Bootstrapping as Bootstrapping
