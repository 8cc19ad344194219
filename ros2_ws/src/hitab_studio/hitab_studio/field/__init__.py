"""The field as pages draw it."""
