"""Kinds of commanders, and their files."""
