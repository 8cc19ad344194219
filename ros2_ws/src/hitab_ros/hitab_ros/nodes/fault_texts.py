"""Texts of faults that keep a robot from acting or perceiving, for all user interfaces."""

from __future__ import annotations

STOPPED = "stopped"
"""Prefix of the fault of a robot that has to stand still."""

WAITS_TO_BE_ARMED = "waits to be armed"
"""Prefix of the reason of a robot that may act again once a person arms it."""

NOT_PUBLISHED = "it has no publisher"
"""Fault without a publisher: the driver is not running, or cannot be reached."""

SILENT = "silent, though it is published; look at the sensor and its driver"
"""Fault with a publisher from which no message arrives."""
