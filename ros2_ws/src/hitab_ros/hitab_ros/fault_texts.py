"""Texts of faults that keep a robot from acting or perceiving, for all user interfaces."""

from __future__ import annotations

STOPPED = "stopped"
"""Begins the fault of a robot that has to stand still."""

NOT_PUBLISHED = "it has no publisher"
"""There is no publisher: the driver is not running, or cannot be reached."""

SILENT = "silent, though it is published; look at the sensor and its driver"
"""There is a publisher, but no message comes."""
