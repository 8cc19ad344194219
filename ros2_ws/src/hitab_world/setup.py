"""Builds the package hitab_world (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_world"

setup(
    name=NAME,
    version="0.1.0",
    description="The node that puts any simulated world on topics and services.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed", "**/*.pyi", "**/*.json", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
    ],
    install_requires=[
        "setuptools",
        "lazy_loader",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
)
