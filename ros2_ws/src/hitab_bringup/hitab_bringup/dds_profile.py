"""How quickly processes find each other, and how quickly a killed one is forgotten."""

from __future__ import annotations

from collections.abc import MutableMapping
from pathlib import Path

VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""What Fast DDS reads, in its older and in its newer versions."""

PROFILE = Path(__file__).with_suffix(".xml")


def choose_profile(environment: MutableMapping[str, str]) -> None:
    """Have processes with this environment use our profile, unless the user has one."""
    if not any(environment.get(name) for name in VARIABLES):
        for name in VARIABLES:
            environment[name] = str(PROFILE)
