"""Files that come with this package: swarms, lessons, trained libraries."""

from __future__ import annotations

import sys
from pathlib import Path

from hitab_core import HitabError, has

PACKAGE = "hitab_bringup"


def shipped(folder: str) -> Path:
    """Return the folder of this name that the package brings.

    It lies beside the Python package in a checkout, and under ``share`` once installed.
    """
    beside = Path(__file__).resolve().parents[1] / folder
    if beside.is_dir():
        return beside
    for prefix in _prefixes():
        installed = prefix / "share" / PACKAGE / folder
        if installed.is_dir():
            return installed
    raise HitabError(f"the {folder} of {PACKAGE} are not installed; install the package again")


def _prefixes() -> list[Path]:
    try:
        from ament_index_python.packages import get_package_prefix

        return [Path(get_package_prefix(PACKAGE)), Path(sys.prefix)]
    except (ImportError, LookupError):
        return [Path(sys.prefix)]


def find_file(given: str, folder: str, what: str) -> Path:
    """Return the file that a user means: a path, or the name of a shipped one without suffix.

    Raises:
        HitabError: naming what is shipped.
    """
    path = Path(given)
    if path.is_file():
        return path
    place = shipped(folder)
    for candidate in (place / given, place / f"{given}.yaml"):
        if candidate.is_file():
            return candidate
    names = [p.stem for p in place.glob("*.yaml")]
    raise HitabError(f'no {what} "{given}": not a file, and not one that is shipped {has(names)}')
