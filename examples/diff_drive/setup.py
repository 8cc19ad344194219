"""Builds the package diff_drive (ament_python)."""

from setuptools import find_packages, setup

NAME = "diff_drive"

setup(
    name=NAME,
    version="0.1.0",
    description="An example of a robot for HiTAB: the domain of a differential-drive robot.",
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
    entry_points={
        "console_scripts": ["simulated_robot = diff_drive.simulated_robot:main"],
        "hitab.domains": ["diff_drive = diff_drive.domain:DOMAIN"],
    },
)
