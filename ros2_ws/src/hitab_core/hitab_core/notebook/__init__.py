"""Training from a notebook or a script."""
