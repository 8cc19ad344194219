"""Builds the package hitab_rcssserver (ament_python)."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "hitab_rcssserver"

setup(
    name=NAME,
    version="0.1.0",
    description="The soccer games of HiTAB on a RoboCup Soccer Simulator (rcssserver).",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
        (f"share/{NAME}/swarms", [str(path) for path in sorted(Path("swarms").glob("*.yaml"))]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    entry_points={
        "console_scripts": [
            "rcss_world = hitab_rcssserver.keepaway_main:main",
        ],
        "hitab.shipped": ["hitab_rcssserver = hitab_rcssserver"],
        "hitab.worlds": [
            "half_field_rcssserver = hitab_rcssserver.half_field_main",
            "rcssserver = hitab_rcssserver.keepaway_main",
        ],
    },
)
