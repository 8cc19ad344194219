"""Verbs for newcomers."""
