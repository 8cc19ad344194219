"""Where a behavior comes from."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a behavior comes from.

    Attributes:
        version: counts how often it was saved, from 1.
        created: when this version was saved, ISO 8601.
        author: who trained it.
        agent: the agent that was trained.
        tool: what wrote the file.
        earlier: checksum of the version before; empty for the first.
        note: anything else worth telling.
    """

    version: int = 1
    created: str = ""
    author: str = ""
    agent: str = ""
    tool: str = ""
    earlier: str = ""
    note: str = ""


def time_now() -> str:
    """Return the time as files state it: ISO 8601, in UTC, to the second."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def tool_name() -> str:
    """Return the name of this package and, if it is installed, its version."""
    try:
        return f"hitab_core {version('hitab_core')}"
    except PackageNotFoundError:
        return "hitab_core"
