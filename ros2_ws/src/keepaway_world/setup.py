"""Builds the package keepaway_world (ament_python)."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "keepaway_world"
DATA = ("exercises", "lessons", "libraries", "swarms")


def shipped(folder: str) -> list[tuple[str, list[str]]]:
    """Return the files of a data folder to install, for `data_files`."""
    files = (path for path in sorted(Path(folder).rglob("*")) if path.is_file())
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in files]


setup(
    name=NAME,
    version="0.1.0",
    description="Keepaway soccer: the simulated world, and the keepers' domain for HiTAB.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed", "**/*.pyi", "**/*.json", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
        *[entry for folder in DATA for entry in shipped(folder)],
    ],
    install_requires=["setuptools", "lazy_loader", "pymunk"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    entry_points={
        "console_scripts": ["keepaway_world = keepaway_world.world_main:main"],
        "hitab.shipped": ["keepaway_world = keepaway_world"],
        "hitab.domains": [
            "keepaway = keepaway_world.domain:DOMAIN",
            "keepaway_continuous = keepaway_world.game.continuous:DOMAIN",
            "keepaway_handcoded = keepaway_world.hand_coded_team:DOMAIN",
        ],
        "hitab.demos": ["keepaway = keepaway_world.demo:DEMO"],
    },
)
