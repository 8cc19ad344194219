"""A robot of one's own: the domain and the ROS link of a differential-drive robot."""
