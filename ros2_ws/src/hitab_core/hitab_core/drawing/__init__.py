"""Automata as pictures and text."""
