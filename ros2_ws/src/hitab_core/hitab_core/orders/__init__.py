"""Orders of a commander, reports to it, and an agent as a subordinate."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
