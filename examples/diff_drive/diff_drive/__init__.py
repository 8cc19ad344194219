"""A robot of one's own: the domain of a differential-drive robot."""
