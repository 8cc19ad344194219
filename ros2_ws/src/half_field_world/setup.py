"""Builds the package half_field_world (ament_python)."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "half_field_world"
DATA = ("lessons", "libraries", "swarms")


def shipped(folder: str) -> list[tuple[str, list[str]]]:
    """Return the files of a data folder to install, for `data_files`."""
    files = (path for path in sorted(Path(folder).rglob("*")) if path.is_file())
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in files]


setup(
    name=NAME,
    version="0.1.0",
    description="Half-field attack: three attackers in roles against defenders and a goalie.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed", "**/*.pyi"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
        *[entry for folder in DATA for entry in shipped(folder)],
    ],
    install_requires=["setuptools", "lazy_loader"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    entry_points={
        "console_scripts": ["half_field_world = half_field_world.world_main:main"],
        "hitab.shipped": ["half_field_world = half_field_world"],
        "hitab.domains": ["half_field = half_field_world.domain:DOMAIN"],
        "hitab.worlds": ["half_field = half_field_world.world_main"],
    },
)
