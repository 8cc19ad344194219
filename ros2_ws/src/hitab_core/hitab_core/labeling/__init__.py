"""Which behavior each moment of a run was that somebody showed without commands."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
