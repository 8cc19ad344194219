"""Demonstrating by keys and buttons: what is commanded, to whom, and driving robots by hand."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
