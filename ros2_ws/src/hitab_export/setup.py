"""Builds the package hitab_export (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_export"

setup(
    name=NAME,
    version="0.1.0",
    description="Learned behaviors as programs: Python, C++, BehaviorTree.CPP.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed", "**/*.pyi", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
    ],
    install_requires=["setuptools", "lazy_loader", "typer"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    entry_points={"hitab.verbs": ["export = hitab_export.verb"]},
)
