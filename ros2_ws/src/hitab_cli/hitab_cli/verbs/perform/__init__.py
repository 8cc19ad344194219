"""Verbs that have agents perform, and evaluate what they do."""
