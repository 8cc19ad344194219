"""The node that puts any simulated world on topics and services."""
