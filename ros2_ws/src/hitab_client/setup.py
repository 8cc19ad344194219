"""Builds the package hitab_client (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_client"

setup(
    name=NAME,
    version="0.1.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "**/*.pyi", "**/*.xml", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
    ],
    install_requires=[
        "setuptools",
        "lazy_loader",
        "mcap",
        "psutil",
        "pydantic",
        "PyYAML",
        "rich",
        "typer",
    ],
    extras_require={"test": ["pytest", "hypothesis", "rosbags"]},
    zip_safe=False,
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    description="What programs talk to a swarm with: agents, world, commanders, lessons",
    license="Apache-2.0",
    python_requires=">=3.11",
)
