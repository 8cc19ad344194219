"""Builds the distribution `hitab`: the main packages of ros2_ws/src in one wheel, without ROS.

What a package consists of, its commands and its data are said once, in its own ``setup.py``, which
colcon reads too. Its share folder is installed below the environment's prefix, as colcon does.
The messages are a distribution of their own, `hitab-msgs`, since they are compiled, and so is each
optional package (``scripts/wheels``).
"""

from __future__ import annotations

import os
from distutils.core import run_setup
from pathlib import Path
from typing import Any

from setuptools import setup

ROOT = Path(__file__).resolve().parent
OPTIONAL = (ROOT / "requirements/optional.txt").read_text().split()
SOURCES = sorted(
    path.parent for path in ROOT.glob("ros2_ws/src/*/setup.py") if path.parent.name not in OPTIONAL
)


def of_package(folder: Path) -> Any:
    """Return what the ``setup.py`` of a package says, without doing anything."""
    os.chdir(folder)
    try:
        return run_setup("setup.py", stop_after="init")
    finally:
        os.chdir(ROOT)


packages: list[str] = []
places: dict[str, str] = {}
data: list[tuple[str, list[str]]] = []
entry_points: dict[str, list[str]] = {}
for folder in SOURCES:
    said, here = of_package(folder), folder.relative_to(ROOT)
    packages += said.packages
    places |= {name: str(here / name.replace(".", "/")) for name in said.packages}
    data += [(to, [str(here / file) for file in files]) for to, files in said.data_files]
    for group, points in (said.entry_points or {}).items():
        entry_points.setdefault(group, []).extend(points)

setup(
    packages=packages,
    package_dir=places,
    package_data={
        "": [
            "py.typed",
            "**/*.pyi",
            "**/*.json",
            "**/*.yaml",
            "**/*.xml",
            "static/*",
            "templates/**/*",
        ]
    },
    data_files=data,
    entry_points=entry_points,
)
