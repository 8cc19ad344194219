"""Each package declares what it needs, so that it can be installed without this workspace."""

import ast
import re
import sys
from graphlib import TopologicalSorter
from pathlib import Path
from xml.etree import ElementTree

from ament_index_python.packages import get_packages_with_prefixes

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "ros2_ws" / "src"
CALLED = {
    "PIL": "pillow",
    "sklearn": "scikit-learn",
    "yaml": "PyYAML",
}
"""Names on PyPI of modules that have another name there."""

STARTED = {"setuptools", "supervisor"}
"""What packages need without importing it."""

PACKAGES = sorted(path.parent.parent for path in SOURCES.glob("*/*/__init__.py"))
MANIFESTS = sorted([*SOURCES.glob("*/package.xml"), *ROOT.glob("examples/*/package.xml")])

BY_APT = {
    "python3-hypothesis": "hypothesis",
    "python3-jinja2": "jinja2",
    "python3-matplotlib": "matplotlib",
    "python3-numpy": "numpy",
    "python3-pil": "pillow",
    "python3-psutil": "psutil",
    "python3-pytest": "pytest",
    "python3-rich": "rich",
    "python3-scipy": "scipy",
    "python3-sklearn": "scikit-learn",
    "python3-typer": "typer",
    "python3-yaml": "PyYAML",
    "supervisor": "supervisor",
}
"""Keys of rosdep that are packages of Ubuntu 24.04, with their names on PyPI.

See base.yaml and python.yaml of ros/rosdistro. A key that stands for pip is of no use there:
Ubuntu refuses to have pip install beside its own packages (PEP 668).
"""

BESIDE = re.findall(
    r"^[\w-]+", (ROOT / "requirements" / "beside-rosdep.txt").read_text(), re.MULTILINE
)
"""What comes from PyPI into a virtual environment where ROS and Ubuntu have all else."""

BROUGHT = {"fastapi": "nicegui"}
"""What comes with another package."""


def depends(manifest: Path, *kinds: str) -> dict[str, str | None]:
    """Return what a package.xml names, each with the least version that it asks for."""
    found = ElementTree.parse(manifest).getroot()
    named = [element for kind in kinds for element in found.iter(kind)]
    return {str(element.text): element.get("version_gte") for element in named}


ALL = ("depend", "build_depend", "buildtool_depend", "exec_depend", "test_depend")


def imports(package: Path) -> set[str]:
    """Return the modules of others that a package imports, wherever it does so."""
    found = set()
    for path in (package / package.name).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found.add(node.module.partition(".")[0])
    return found - sys.stdlib_module_names - {package.name}


def from_pypi(package: Path) -> set[str]:
    """Return what a package tells pip to install."""
    told = re.search(r"install_requires=\[(.*?)\]", (package / "setup.py").read_text(), re.DOTALL)
    assert told is not None
    return {*re.findall(r"[\w-]+", told[1])}


def test_packages_declare_what_they_import_and_nothing_else_of_this_workspace():
    wrong = {}
    started = {"hitab_agent"}  # as processes of their own, not imported
    for package in PACKAGES:
        text = (package / "package.xml").read_text()
        # A comment names what rosdep does not know.
        missing = imports(package) - {*re.findall(r"\w+", text)}
        ours = {*re.findall(r"<exec_depend>(\w+)</exec_depend>", text)} & {
            p.name for p in PACKAGES
        }
        wrong[package.name] = missing, ours - imports(package) - started
    assert {name: found for name, found in wrong.items() if found != (set(), set())} == {}


def test_packages_tell_pip_what_they_import_from_pypi_and_nothing_else():
    from_ros = {*get_packages_with_prefixes()} | {path.name for path in PACKAGES}
    wanted = {p.name: {CALLED.get(n, n) for n in imports(p) - from_ros} for p in PACKAGES}
    assert {package.name: from_pypi(package) - STARTED for package in PACKAGES} == wanted


def test_packages_name_only_what_ros_or_ubuntu_has():
    ours = {path.parent.name for path in MANIFESTS}
    wrong = {}
    for manifest in MANIFESTS:
        named = depends(manifest, *ALL)
        # Names of ROS packages have no hyphen, all of Ubuntu's here but one have.
        foreign = {name for name in named if "-" in name or name == "supervisor"}
        unversioned = {name for name in named if name in ours and named[name] is None}
        wrong[manifest.parent.name] = foreign - set(BY_APT) | unversioned
    assert {name: found for name, found in wrong.items() if found} == {}


def test_what_packages_need_from_pypi_comes_from_ubuntu_or_into_an_environment():
    missing = {}
    for package in PACKAGES:
        keys = depends(package / "package.xml", "depend", "exec_depend")
        # One that has to be newer than Ubuntu's comes into the environment, too.
        from_ubuntu = {BY_APT.get(key) for key, least in keys.items() if least is None}
        wanted = {BROUGHT.get(name, name) for name in from_pypi(package)}
        missing[package.name] = wanted - {"setuptools"} - from_ubuntu - set(BESIDE)
    assert {name: found for name, found in missing.items() if found} == {}
    assert set(BESIDE) - set().union(*map(from_pypi, PACKAGES)) == set()


def test_packages_do_not_depend_on_one_another_in_a_circle():
    """As colcon sees it, which counts what tests need."""
    names = {manifest.parent.name for manifest in MANIFESTS}
    graph = {m.parent.name: names & set(depends(m, *ALL)) for m in MANIFESTS}
    TopologicalSorter(graph).prepare()


def test_all_packages_have_one_version_and_ask_it_of_one_another():
    (version,) = {ElementTree.parse(m).getroot().findtext("version") for m in MANIFESTS}
    assert f"the version is {version}" in (ROOT / "docs/conventions.md").read_text()
    ours = {manifest.parent.name for manifest in MANIFESTS}
    for manifest in MANIFESTS:
        asked = depends(manifest, *ALL)
        assert {asked[name] for name in ours & asked.keys()} <= {version}, manifest
        if (setup := manifest.parent / "setup.py").exists():
            assert re.findall(r'version="(.*)"', setup.read_text()) == [version]
