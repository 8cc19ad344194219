"""What deserves a look in a swarm: concerns in what it reports, ranked for one person."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
