"""Modes of an agent."""

from __future__ import annotations

from enum import StrEnum


class Mode(StrEnum):
    """Modes of an agent, by the source of its decisions."""

    IDLE = "idle"
    PERFORMING = "performing"
    TRAINING = "training"
    TESTING = "testing"
