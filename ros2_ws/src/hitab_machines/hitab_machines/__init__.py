"""Machines of a swarm: what each runs, whom it hears, and what the others keep of it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
