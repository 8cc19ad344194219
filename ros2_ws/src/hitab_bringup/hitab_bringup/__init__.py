"""Swarm descriptions, lessons and the `hitab` command, on top of the agents' public topics."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
