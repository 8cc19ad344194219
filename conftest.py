"""What holds for all tests of this checkout."""

from hypothesis import HealthCheck, settings

# How long an example takes, or takes to be made, says how busy the machine is, not whether the
# code is right.
settings.register_profile("hitab", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("hitab")
