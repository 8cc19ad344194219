"""Looks for problems that HiTAB would have on this computer."""
