"""Builds the package hitab_bringup (ament_python)."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "hitab_bringup"

setup(
    name=NAME,
    version="0.1.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "**/*.pyi"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
        (f"share/{NAME}/launch", sorted(map(str, Path("launch").glob("*.launch.py")))),
    ],
    install_requires=[
        "setuptools",
        "lazy_loader",
        "psutil",
        "pydantic",
        "supervisor",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    description="Swarm files, supervision of processes, and evaluation without ROS",
    license="Apache-2.0",
    python_requires=">=3.11",
)
