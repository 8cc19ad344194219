"""Evaluation: which agents play, with which libraries, without ROS."""
