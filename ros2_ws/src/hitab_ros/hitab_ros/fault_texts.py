"""How statuses, diagnostics and the studio say what keeps a robot from acting or perceiving."""

from __future__ import annotations

STOPPED = "stopped"
"""Begins the fault of a robot that has to stand still."""

NOT_PUBLISHED = "nobody publishes it"
"""There is no publisher: the driver is not running, or cannot be reached."""

SILENT = "silent, though it is published; look at the sensor and its driver"
"""There is a publisher, but no message comes."""
