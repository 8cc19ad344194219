"""Each package declares what it needs, so that it can be installed without this workspace."""

import ast
import re
import sys
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[1] / "ros2_ws" / "src"
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
