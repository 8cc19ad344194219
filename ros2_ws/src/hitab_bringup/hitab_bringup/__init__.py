"""Swarm descriptions, lessons and the `hitab` command, on top of the agents' public topics."""
