"""Lessons: what to have an agent demonstrate, and when, as a file."""
