"""How it is said that a topic brings nothing: in statuses, diagnostics and the studio."""

from __future__ import annotations

NOT_PUBLISHED = "nobody publishes it"
"""There is no publisher: the driver is not running, or cannot be reached."""

SILENT = "silent, though it is published; look at the sensor and its driver"
"""There is a publisher, but no message comes."""
