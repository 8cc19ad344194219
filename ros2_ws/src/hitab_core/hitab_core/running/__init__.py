"""Performing automata: for one agent, or for many with the same behavior at once."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
