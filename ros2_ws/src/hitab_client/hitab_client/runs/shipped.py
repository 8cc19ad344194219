"""Files shipped with the packages of domains: swarms, lessons, trained libraries.

A package names itself under the entry-point group ``hitab.shipped``; its folders ``swarms``,
``lessons`` and ``libraries`` lie beside its Python package in a checkout, and under ``share`` once
it is installed.
"""

from __future__ import annotations

import os
import sys
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from hitab_core import HitabError, has

SHIPPED_GROUP = "hitab.shipped"


def shipped_folders(folder: str) -> list[Path]:
    """Return the folders of this name, one for each package that has one.

    Raises:
        HitabError: if no package has one.
    """
    packages = sorted({point.value for point in entry_points(group=SHIPPED_GROUP)})
    found = [path for package in packages if (path := _folder(package, folder)) is not None]
    if not found:
        raise HitabError(
            f'no package brings {folder} (entry-point group "{SHIPPED_GROUP}"); '
            "install HiTAB again"
        )
    return found


def _folder(package: str, folder: str) -> Path | None:
    spec = find_spec(package)
    if spec is not None and spec.origin is not None:
        beside = Path(spec.origin).resolve().parents[1] / folder
        if beside.is_dir():
            return beside
    for prefix in _prefixes(package):
        installed = prefix / "share" / package / folder
        if installed.is_dir():
            return installed
    return None


def _prefixes(package: str) -> list[Path]:
    try:
        from ament_index_python.packages import get_package_prefix

        return [Path(get_package_prefix(package)), Path(sys.prefix)]
    except (
        ImportError,
        LookupError,
        OSError,
    ):  # OSError: ROS from wheels needs no set-up
        return [Path(sys.prefix)]


def shipped_names(folder: str) -> list[str]:
    """Return the names of the shipped files of a kind, such as ``captain/tend``."""
    return [
        path.relative_to(place).with_suffix("").as_posix()
        for place in shipped_folders(folder)
        for path in place.rglob("*.yaml")
    ]


def shipped(folder: str, name: str) -> Path:
    """Return the shipped file or folder of this name, such as a library.

    Raises:
        HitabError: if it does not exist; names the shipped files.
    """
    folders = shipped_folders(folder)
    for place in folders:
        if (path := place / name).exists():
            return path
    names = [path.name for place in folders for path in place.iterdir()]
    raise HitabError(f'"{name}" is not among the shipped {folder} {has(names, name)}')


def find_file(given: str, folder: str, what: str) -> Path:
    """Return the requested file: a path, or the name of a shipped file without its suffix.

    Raises:
        HitabError: if it does not exist; names the shipped files.
    """
    path = Path(given)
    if path.is_file():
        return path
    folders = shipped_folders(folder)
    for place in folders:
        if (candidate := place / f"{given}.yaml").is_file():
            return candidate
    if path.is_dir():
        raise HitabError(f'no {what} "{given}": this is a folder; name a file in it')
    names = [p.stem for place in folders for p in place.glob("*.yaml")]
    if os.sep in given:
        names = [str(p) for p in path.parent.glob("*.y*ml")]
    raise HitabError(f'no {what} "{given}": no such file {has(names, given)}')
