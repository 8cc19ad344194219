"""Swarm files, and the description of a swarm with its vocabulary and command tree."""
