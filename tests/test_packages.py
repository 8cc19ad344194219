"""Each package declares what it needs, so that it can be installed without this workspace."""

import ast
import re
import sys
from graphlib import TopologicalSorter
from pathlib import Path
from xml.etree import ElementTree

import pytest
from ament_index_python.packages import get_packages_with_prefixes

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "ros2_ws" / "src"
CALLED = {"yaml": "PyYAML", "sklearn": "scikit-learn", "mcap_ros2": "mcap-ros2-support"}
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


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_a_package_declares_all_that_it_imports(package):
    # A comment names what rosdep does not know.
    declared = re.findall(r"[a-z0-9_]+", (package / "package.xml").read_text())
    assert imports(package) - {*declared} == set()


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_a_package_depends_on_no_other_of_this_workspace_without_need(package):
    declared = re.findall(
        r"<exec_depend>(\w+)</exec_depend>", (package / "package.xml").read_text()
    )
    ours = {path.name for path in PACKAGES} & {*declared}
    started = {"hitab_agent"}  # as processes of their own, not imported
    assert ours - imports(package) - started == set()


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_a_package_tells_pip_what_it_imports_from_pypi_and_nothing_else(package):
    from_ros = {*get_packages_with_prefixes()} | {path.name for path in PACKAGES}
    wanted = {CALLED.get(name, name) for name in imports(package) - from_ros}
    told = re.search(r"install_requires=\[(.*?)\]", (package / "setup.py").read_text(), re.DOTALL)
    assert told is not None
    assert {*re.findall(r"[\w-]+", told[1])} - STARTED == wanted


@pytest.mark.parametrize("manifest", MANIFESTS, ids=lambda manifest: manifest.parent.name)
def test_a_package_names_only_what_ros_or_ubuntu_has(manifest):
    named = depends(manifest, *ALL)
    ours = {path.parent.name for path in MANIFESTS}
    # Names of ROS packages have no hyphen, all of Ubuntu's here but one have.
    foreign = {name for name in named if "-" in name or name == "supervisor"}
    assert foreign - set(BY_APT) == set()
    assert {name for name in named if name in ours and named[name] is None} == set()


def test_all_packages_have_the_version_that_they_ask_of_one_another():
    versions = {
        manifest.parent.name: ElementTree.parse(manifest).getroot().findtext("version")
        for manifest in MANIFESTS
    }
    for manifest in MANIFESTS:
        for name, least in depends(manifest, *ALL).items():
            assert name not in versions or least == versions[name], (manifest.parent.name, name)


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_what_a_package_needs_from_pypi_comes_from_ubuntu_or_into_an_environment(package):
    told = re.search(r"install_requires=\[(.*?)\]", (package / "setup.py").read_text(), re.DOTALL)
    assert told is not None
    keys = depends(package / "package.xml", "depend", "exec_depend")
    # One that has to be newer than Ubuntu's comes into the environment, too.
    from_ubuntu = {BY_APT.get(key) for key, least in keys.items() if least is None}
    wanted = {BROUGHT.get(name, name) for name in re.findall(r"[\w-]+", told[1])}
    assert wanted - {"setuptools"} - from_ubuntu - set(BESIDE) == set()


def test_nothing_comes_into_the_environment_that_no_package_needs():
    told = "".join((package / "setup.py").read_text() for package in PACKAGES)
    assert [name for name in BESIDE if f'"{name}"' not in told] == []


@pytest.mark.parametrize("manifest", MANIFESTS, ids=lambda manifest: manifest.parent.name)
def test_colcon_knows_how_to_build_a_package_and_finds_its_tests(manifest):
    kind = "ament_python" if (manifest.parent / "setup.py").exists() else "ament_cmake"
    assert ElementTree.parse(manifest).getroot().findtext("export/build_type") == kind
    if any(manifest.parent.glob("test/test_*.py")):
        setup = (manifest.parent / "setup.py").read_text()
        assert re.search(r'extras_require=\{"test": \[.*"pytest"', setup), "colcon runs no test"
        assert "python3-pytest" in depends(manifest, "test_depend")


def test_packages_do_not_depend_on_one_another_in_a_circle():
    """As colcon sees it, which counts what tests need."""
    names = {manifest.parent.name for manifest in MANIFESTS}
    graph = {m.parent.name: names & set(depends(m, *ALL)) for m in MANIFESTS}
    TopologicalSorter(graph).prepare()


@pytest.mark.parametrize(
    "manifest", sorted(SOURCES.glob("*/package.xml")), ids=lambda path: path.parent.name
)
def test_a_package_names_its_license_and_brings_its_text(manifest):
    element = ElementTree.parse(manifest).getroot().find("license")
    assert element is not None
    assert element.text == "Apache-2.0"
    # A copy: a package may be released, or taken out of this checkout, by itself.
    text = (manifest.parent / str(element.get("file"))).read_text()
    assert text == (ROOT / "LICENSE").read_text()
    setup = manifest.parent / "setup.py"
    if not setup.is_file():
        assert "install(FILES LICENSE " in (manifest.parent / "CMakeLists.txt").read_text()
        return
    assert 'license="Apache-2.0"' in setup.read_text()
    assert '(f"share/{NAME}", ["LICENSE", "package.xml"' in setup.read_text()
