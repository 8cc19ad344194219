"""Keepaway soccer: the world, its referee and takers, and the keepers' body and vocabulary."""
