"""Builds the package hitab_machines (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_machines"

setup(
    name=NAME,
    version="0.1.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "**/*.pyi"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
    ],
    install_requires=[
        "setuptools",
        "lazy_loader",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    description="Swarms on several machines: signs of life, files, leases and moves",
    license="Apache-2.0",
    python_requires=">=3.11",
)
