"""Verbs that make agents perform, and evaluate them."""
