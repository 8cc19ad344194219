from .export import LANGUAGES as LANGUAGES
from .export import exported as exported
