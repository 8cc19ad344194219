"""Builds the package foraging_world (ament_python)."""

from setuptools import find_packages, setup

NAME = "foraging_world"

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
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=["setuptools", "numpy", "pymunk"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    entry_points={
        "console_scripts": ["foraging_world = foraging_world.world_main:main"],
        "hitab.domains": ["foraging = foraging_world.domain:DOMAIN"],
    },
)
