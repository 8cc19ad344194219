"""Texts for people: errors, remedies and wording."""
