"""Builds the package irsim_robots (ament_python)."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "irsim_robots"
libraries = [
    (f"share/{NAME}/{folder}", sorted(map(str, folder.glob("*.yaml"))))
    for folder in (Path("libraries/robot"), Path("libraries/captain"))
]

setup(
    name=NAME,
    version="0.1.0",
    description="An example for HiTAB: robots in ir-sim, a simulator that knows nothing of it.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml", "school.yaml", "swarm.yaml"]),
        *libraries,
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    entry_points={
        "console_scripts": ["bridge = irsim_robots.bridge:main"],
        "hitab.domains": ["irsim = irsim_robots.domain:DOMAIN"],
    },
)
