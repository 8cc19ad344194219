"""The node, its parameters and its diagnosis."""
