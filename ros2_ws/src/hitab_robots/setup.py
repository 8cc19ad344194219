"""Builds the package hitab_robots (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_robots"

setup(
    name=NAME,
    version="0.1.0",
    description="Robots with the standard sensors and drives: ready words, and the link to them.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed", "**/*.pyi", "**/*.json", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
    ],
    install_requires=["setuptools", "lazy_loader", "numpy"],
    extras_require={"test": ["pytest", "hypothesis"]},
    zip_safe=True,
    entry_points={
        "console_scripts": ["velocity_relay = hitab_robots.relay.velocity_relay:main"],
    },
)
