"""Swarm files: read into a description of the swarm, with its vocabulary and command tree."""
