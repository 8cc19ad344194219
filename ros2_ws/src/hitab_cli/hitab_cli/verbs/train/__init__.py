"""Verbs that train agents."""
