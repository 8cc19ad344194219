"""A page and its parts."""
