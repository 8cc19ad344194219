from .joystick import JoystickInput as JoystickInput
from .joystick_mapping import read_mapping as read_mapping
