"""What docs/conventions.md claims about packages and messages."""

import ast
import re
from pathlib import Path
from xml.etree import ElementTree

from mentions import ROOT

SOURCES = ROOT / "ros2_ws" / "src"
MANIFESTS = sorted(SOURCES.glob("*/package.xml"))
INTERFACES = sorted(
    path for kind in ("msg", "srv", "action") for path in SOURCES.glob(f"hitab_msgs/{kind}/*.*")
)
PAGE = (ROOT / "docs" / "conventions.md").read_text()


def fields(interface: Path) -> list[tuple[str, str]]:
    """Return types and names of the fields."""
    return re.findall(
        r"^([\w/]+(?:\[\w*\])?) +(\w+)(?: *#.*)?$", interface.read_text(), re.MULTILINE
    )


def test_all_packages_have_one_version():
    versions = {str(ElementTree.parse(path).getroot().findtext("version")) for path in MANIFESTS}
    (version,) = versions
    assert f"it is {version}" in PAGE
    for setup in SOURCES.glob("*/setup.py"):
        (written,) = re.findall(r'version="(.*)"', setup.read_text())
        assert written == version


def test_messages_with_places_have_a_header():
    placed = {"Entity[]", "geometry_msgs/Pose", "geometry_msgs/Point"}
    for path in INTERFACES:
        if path.suffix == ".msg" and placed & {kind for kind, _ in fields(path)}:
            assert ("std_msgs/Header", "header") in fields(path), path.name


def test_only_the_topics_that_the_page_names_are_absolute():
    found = set()
    for path in SOURCES.glob("hitab_*/hitab_*/**/*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                found |= set(re.findall(r"^/[a-z_]+$", node.value))
    topics = {"/clock", "/rosout", "/diagnostics", "/emergency_stop"}
    assert all(f"`{name}`" in PAGE for name in topics)
    assert topics <= found


def test_no_feature_has_a_unit_other_than_si():
    units = set()
    for path in SOURCES.glob("*/*/**/*.py"):
        units |= set(re.findall(r'unit="([^"]*)"', path.read_text()))
    assert units <= {"m", "rad", "s", "m/s", "rad/s", "m/s²", "V", ""}
