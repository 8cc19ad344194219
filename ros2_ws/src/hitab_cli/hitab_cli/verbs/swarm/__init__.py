"""Verbs for a swarm: its processes, status, logs, recordings and world."""
