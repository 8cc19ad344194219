"""Running many agents in one process, for which percepts are handled together."""
