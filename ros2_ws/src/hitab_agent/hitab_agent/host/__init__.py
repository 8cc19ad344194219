"""Running many agents in one process and handling their percepts together."""
