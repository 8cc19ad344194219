"""Swarm files, the processes of a swarm, its libraries, and evaluation without ROS."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
