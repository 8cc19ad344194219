"""ROS actions: those that are basic behaviors of an agent, and the one that an agent offers.

Few agents use actions, and rclpy takes a while to import them, so they are loaded on demand.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
