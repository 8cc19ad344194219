"""Builds the package hitab_cli (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_cli"

setup(
    name=NAME,
    version="0.1.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "**/*.pyi", "templates/**/*.txt"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
    ],
    install_requires=[
        "setuptools",
        "lazy_loader",
        "matplotlib",
        "psutil",
        "rich",
        "typer",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    description="The hitab command, on top of the agents' public topics and services",
    license="Apache-2.0",
    python_requires=">=3.11",
    entry_points={
        "console_scripts": ["hitab = hitab_cli.program:main"],
    },
)
