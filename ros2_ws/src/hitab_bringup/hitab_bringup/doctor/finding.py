"""Findings of `hitab doctor`."""

from __future__ import annotations

from dataclasses import dataclass

OK, WARNING, ERROR = "ok", "warning", "error"


@dataclass(frozen=True)
class Finding:
    """A finding of the doctor.

    Attributes:
        about: the examined thing, such as "Python".
        text: the finding.
        level: `OK`; `WARNING` for possible problems; `ERROR` if HiTAB cannot work.
        way_out: the remedy; empty without one.
    """

    about: str
    text: str
    level: str = OK
    way_out: str = ""


def judged(about: str, text: str, good: bool, way_out: str, level: str = WARNING) -> Finding:
    """Return a finding: `OK` if good, else with a level and a way out."""
    return Finding(about, text) if good else Finding(about, text, level, way_out)
