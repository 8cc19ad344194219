"""The agent node, and the host that runs many of them in one process."""
