"""Builds the package hitab_core (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_core"

setup(
    name=NAME,
    version="0.1.0",
    description="The HiTAB engine without ROS: automata, learning, training, library.",
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
        "matplotlib",
        "numpy",
        "pydantic",
        "PyYAML",
        "scikit-learn",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
)
