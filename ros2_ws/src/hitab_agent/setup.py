"""Builds the package hitab_agent (ament_python)."""

from setuptools import find_packages, setup

NAME = "hitab_agent"

setup(
    name=NAME,
    version="0.1.0",
    description="The ROS 2 node of a trained agent, and the host that runs many of them.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(exclude=["test", "test.*"]),
    package_data={"": ["py.typed", "**/*.pyi", "**/*.json", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
    ],
    install_requires=["setuptools", "lazy_loader"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    entry_points={
        "console_scripts": [
            "hitab_agent = hitab_agent.agent_main:main",
            "hitab_host = hitab_agent.host_main:main",
        ],
    },
)
