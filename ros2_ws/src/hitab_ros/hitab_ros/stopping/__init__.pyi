from . import emergency_stop as emergency_stop
