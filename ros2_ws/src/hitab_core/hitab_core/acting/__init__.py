"""What an agent does with its percepts, in time and back in time."""
