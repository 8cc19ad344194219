"""Behavior bootstrapping: generations of a behavior, given to a team and kept with scores."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
