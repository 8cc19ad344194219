"""Robots in ir-sim, a simulator that knows nothing of HiTAB: its bridge to ROS, and the words."""
