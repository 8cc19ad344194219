"""Builds the package keepaway_research (ament_python)."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "keepaway_research"
DATA = ("lessons", "libraries", "swarms")


def shipped(folder: str) -> list[tuple[str, list[str]]]:
    """Return what is to be installed of a data folder, for `data_files`."""
    files = (path for path in sorted(Path(folder).rglob("*")) if path.is_file())
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in files]


setup(
    name=NAME,
    version="0.1.0",
    description="UT Austin's keepaway players, and keepers beyond the paper, for measurements.",
    maintainer="HiTAB developers",
    maintainer_email="hitab@example.org",
    license="Apache-2.0",
    packages=find_packages(),
    package_data={"": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["LICENSE", "package.xml"]),
        *[entry for folder in DATA for entry in shipped(folder)],
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    entry_points={
        "hitab.shipped": ["keepaway_research = keepaway_research"],
        "hitab.domains": [
            "keepaway_predictive = keepaway_research.predictive.domain:DOMAIN",
            "keepaway_fullspeed = keepaway_research.fullspeed.domain:DOMAIN",
        ],
        "keepaway.takers": ["reference = keepaway_research.reference.takers:ReferenceTakers"],
        "keepaway.keepers": [
            "hand = keepaway_research.reference.keepers:hand_coded",
            "rand = keepaway_research.reference.keepers:random",
            "hold = keepaway_research.reference.keepers:holding",
        ],
    },
)
