from .labeling import Run as Run
from .labeling import Shown as Shown
from .labeling import label as label
from .labeling import steps_of as steps_of
from .likelihood import apart as apart
from .paths import forward as forward
