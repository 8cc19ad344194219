"""Robots with the standard sensors and drives: ready words, the link to them, and the relay.

Declaring a robot and its words needs no ROS; only the link and the relay load it.

    Robot, Drive             what a robot has: the body of a domain
    Odometry, Scan, Sector,  its sensors, each with its values and its mount
    Battery, Imu, Range,
    Joints, Mount
    motion, reading, ...     ready words: basic behaviors, features and targets
    RobotLink                for `Domain.of(..., link="hitab_robots:RobotLink")`
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
