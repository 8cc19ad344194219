"""Client library for a swarm: its agents, its world, its commanders, and lessons."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
