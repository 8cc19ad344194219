"""Recordings of swarms and robots as bags (MCAP): writing them, finding them and reading them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
