"""The `hitab` command: its verbs, and what other packages make their verbs of."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
