"""The verbs of the `hitab` command, a module for each group of them.

What costs time to import (rclpy, numpy, matplotlib) is imported inside the verbs that need it.
"""
