from .labels import Run as Run
from .labels import Shown as Shown
from .labels import examples_of as examples_of
from .labels import label as label
from .labels import steps_of as steps_of
from .likelihood import apart as apart
from .paths import forward as forward
