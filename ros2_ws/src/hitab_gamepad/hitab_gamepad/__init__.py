"""Gamepads as the keys of a demonstrator; their sticks give velocities and numbers."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
