"""What holds for all tests of this checkout."""

from hypothesis import settings

# How long an example takes says how busy the machine is, not whether the code is right.
settings.register_profile("hitab", deadline=None)
settings.load_profile("hitab")
