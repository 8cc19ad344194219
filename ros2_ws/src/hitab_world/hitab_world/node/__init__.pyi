from . import ros_parameters as ros_parameters
