"""The verbs of the `hitab` command, one module per group.

Slow imports (rclpy, numpy, matplotlib) happen inside the verbs that need them.
"""
