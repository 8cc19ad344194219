"""Performing automata: one agent, or many of the same behavior at once."""
