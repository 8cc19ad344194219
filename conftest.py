"""What holds for all tests of this checkout."""

import signal

from hypothesis import HealthCheck, settings

# How long an example takes, or takes to be made, says how busy the machine is, not whether the
# code is right.
settings.register_profile("hitab", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("hitab")

# A shell that runs this in the background has its processes ignore Ctrl-C, and so those that the
# tests start; with a handler of its own these begin with the default again.
signal.signal(signal.SIGINT, signal.default_int_handler)
