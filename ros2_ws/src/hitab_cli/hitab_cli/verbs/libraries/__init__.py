"""Verbs for libraries of trained behaviors."""
