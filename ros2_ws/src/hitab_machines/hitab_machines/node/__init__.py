"""The node of a machine: its signs, faults, services and starts of lost processes."""
