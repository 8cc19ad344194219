"""What the doctor finds."""

from __future__ import annotations

from dataclasses import dataclass

OK, WARNING, ERROR = "ok", "warning", "error"


@dataclass(frozen=True)
class Finding:
    """One finding.

    Attributes:
        about: what was looked at, such as "Python".
        text: what was found.
        level: `OK`, `WARNING` or `ERROR`.
        way_out: what to do about it; empty: nothing.
    """

    about: str
    text: str
    level: str = OK
    way_out: str = ""


def warning(about: str, text: str, way_out: str) -> Finding:
    """Return a finding that may cause problems."""
    return Finding(about, text, WARNING, way_out)


def error(about: str, text: str, way_out: str) -> Finding:
    """Return a finding that keeps HiTAB from working."""
    return Finding(about, text, ERROR, way_out)
