"""Talking to a swarm: its agents, its world, its commanders, and lessons for them."""
