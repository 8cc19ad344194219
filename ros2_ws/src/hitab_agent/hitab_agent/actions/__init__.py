"""ROS actions: as basic behaviors of an agent, and one by which it offers its own behaviors.

Few agents have any, so they are loaded on demand: rclpy's take a while.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
