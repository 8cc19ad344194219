"""Origin of a behavior."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

from hitab_core.library.installation import installed_version


@dataclass(frozen=True, slots=True)
class Provenance:
    """Origin of a behavior.

    Attributes:
        version: number of times it was saved.
        created: time when this version was saved, ISO 8601.
        author: person who trained it.
        agent: the agent that was trained.
        tool: program that wrote the file.
        earlier: checksum of the previous version; empty for the first.
        note: free text.
    """

    version: int = 1
    created: str = ""
    author: str = ""
    agent: str = ""
    tool: str = ""
    earlier: str = ""
    note: str = ""


def time_now() -> str:
    """Return the current time as ISO 8601, in UTC, to the second."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def tool_name() -> str:
    """Return the name of this package and, if it is installed, its version."""
    return f"hitab_core {installed_version()}".rstrip()
