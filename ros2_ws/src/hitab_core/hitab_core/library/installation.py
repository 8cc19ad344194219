"""Installation of this HiTAB: by pip, from a checkout, or with a ROS 2 workspace."""

from __future__ import annotations

from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

BY_PIP, BY_SETUP = "hitab", "hitab_core"
"""The distribution that pip installs, and one of several in a checkout or workspace."""


def installed_version() -> str:
    """Return the version of HiTAB; "" if it is unknown."""
    return _version(BY_PIP) or _version(BY_SETUP)


def installed_as() -> str:
    """Return where this HiTAB is from, such as "installed by pip"."""
    if _version(BY_PIP):
        return "installed by pip"
    top = _checkout()
    return "of a ROS 2 workspace" if top is None else f"of the checkout {top}"


def way_to_install(extras: str = "ros") -> str:
    """Return the way to install HiTAB again, or a missing part.

    Args:
        extras: extras of the distribution `hitab` that contain the part.
    """
    if _version(BY_PIP):
        return f'run `pip install --upgrade "hitab[{extras}]"`'
    top = _checkout()
    if top is None:
        return "build the ROS 2 workspace of HiTAB again, and source its set-up file"
    return f"run `{top}/scripts/setup` and use `{top}/scripts/hitab`"


def _version(distribution: str) -> str:
    with suppress(PackageNotFoundError):
        return version(distribution)
    return ""


def _checkout() -> Path | None:
    """Return the top of the checkout that this file is in."""
    above = Path(__file__).resolve().parents
    found = above[5] if len(above) > 5 else above[0]
    return found if (found / "scripts/setup").is_file() else None
