"""Looks for what would hinder HiTAB on this computer."""
