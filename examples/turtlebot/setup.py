"""Builds the package turtlebot_example (ament_python)."""

from setuptools import find_packages, setup

NAME = "turtlebot_example"

setup(
    name=NAME,
    version="0.1.0",
    description="An example of a robot for HiTAB: the domain of a TurtleBot.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml", "swarm.yaml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    entry_points={"hitab.domains": ["turtlebot = turtlebot_example.domain:DOMAIN"]},
)
