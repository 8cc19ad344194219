"""The verbs of the `hitab` command, one folder per group.

Slow imports (rclpy, numpy, matplotlib) happen inside the verbs that need them.
"""
