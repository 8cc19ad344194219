"""Builds the package hitab_studio (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_studio"

setup(
    name=NAME,
    version="0.1.0",
    description="The demonstrator's console in the browser.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={NAME: ["py.typed", "static/*", "templates/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
        (f"share/{NAME}/viewers", ["viewers/field.rviz", "viewers/keepaway.foxglove.json"]),
    ],
    install_requires=[
        "setuptools",
        "fastapi",
        "jinja2",
        "nicegui",
        "numpy",
        "pillow",
        "typer",
    ],
    extras_require={"test": ["pytest", "playwright", "axe-playwright-python"]},
    entry_points={"hitab.verbs": ["studio = hitab_studio.command"]},
    python_requires=">=3.11",
    zip_safe=False,
)
