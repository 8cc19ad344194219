"""The velocity relay."""
