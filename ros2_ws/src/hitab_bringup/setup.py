"""Package of swarm descriptions, lessons, trained libraries and the `hitab` command."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "hitab_bringup"
DATA = ("launch",)


def shared(folder: str) -> list[tuple[str, list[str]]]:
    """Return what is to be installed of a data folder, for `data_files`."""
    files = sorted(path for path in Path(folder).rglob("*") if path.is_file())
    by_folder: dict[str, list[str]] = {}
    for path in files:
        if "__pycache__" not in path.parts:
            by_folder.setdefault(f"share/{NAME}/{path.parent}", []).append(str(path))
    return list(by_folder.items())


setup(
    name=NAME,
    version="0.1.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "**/*.pyi"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *[entry for folder in DATA for entry in shared(folder)],
    ],
    install_requires=[
        "setuptools",
        "lazy_loader",
        "typer",
        "rich",
        "PyYAML",
        "psutil",
        "supervisor",
        "matplotlib",
    ],
    zip_safe=False,
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    description="Swarm descriptions, lessons, trained libraries and the hitab command",
    license="Apache-2.0",
    python_requires=">=3.11",
    entry_points={
        "console_scripts": ["hitab = hitab_bringup.main:main"],
    },
)
