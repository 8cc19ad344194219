"""Builds the package hitab_commander (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_commander"

setup(
    name=NAME,
    version="0.1.0",
    description="The ROS 2 node of a virtual commander, trained as an agent is.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed", "**/*.pyi", "**/*.json", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
    ],
    install_requires=["setuptools", "lazy_loader", "pydantic", "PyYAML"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    entry_points={
        "console_scripts": ["hitab_commander = hitab_commander.commander_main:main"],
    },
)
