"""Each package declares what it needs, so that it can be installed without this workspace."""

import ast
import re
import sys
from pathlib import Path

import pytest
from ament_index_python.packages import get_packages_with_prefixes

SOURCES = Path(__file__).parents[1] / "ros2_ws" / "src"
CALLED = {"yaml": "PyYAML", "sklearn": "scikit-learn", "mcap_ros2": "mcap-ros2-support"}
"""Names on PyPI of modules that have another name there."""

STARTED = {"setuptools", "supervisor"}
"""What packages need without importing it."""

PACKAGES = sorted(path.parent.parent for path in SOURCES.glob("*/*/__init__.py"))


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
