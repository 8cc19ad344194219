"""Assistants of a person who trains: each module subscribes to a training and can be left out."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
