"""Builds the package foraging_world (ament_python)."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "foraging_world"
DATA = ("exercises", "lessons", "libraries", "swarms")


def shipped(folder: str) -> list[tuple[str, list[str]]]:
    """Return the files to install from a data folder, for `data_files`."""
    files = (path for path in sorted(Path(folder).rglob("*")) if path.is_file())
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in files]


setup(
    name=NAME,
    version="0.1.0",
    description="Box foraging by swarms: the simulated world, and the foragers' domain for HiTAB.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed", "**/*.json", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
        *[entry for folder in DATA for entry in shipped(folder)],
    ],
    install_requires=["setuptools", "numpy", "pymunk"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    entry_points={
        "console_scripts": ["foraging_world = foraging_world.world_main:main"],
        "hitab.shipped": ["foraging_world = foraging_world"],
        "hitab.domains": ["foraging = foraging_world.domain:DOMAIN"],
    },
)
