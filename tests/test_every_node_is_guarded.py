"""No node can forget the guard: each is a `GuardedNode`, and each executor is spun guarded.

A node made otherwise, or an executor spun otherwise, ends its process at the first exception that
a callback raises.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[1] / "ros2_ws" / "src"
MODULES = sorted(
    path for package in SOURCES.glob("*/*/__init__.py") for path in package.parent.rglob("*.py")
)
GUARDS = {"hitab_ros/guarded_node.py"}  # where the guarded node is made of a bare one
SPINS = {
    "hitab_ros/spinning.py",  # the guarded spin
    "hitab_client/ros_link.py",  # its own: what a subscriber raises is for the command to see
    "hitab_ros/testing.py",  # for tests: what a callback raises fails them
}


def makes_bare_node(tree: ast.AST) -> Iterator[int]:
    """Yield the lines in which a node is made, or a class of nodes, that is not guarded."""
    for part in ast.walk(tree):
        made = (
            [part.func] if isinstance(part, ast.Call)
            else part.bases if isinstance(part, ast.ClassDef)
            else []
        )  # fmt: skip
        for name in map(ast.unparse, made):
            if name in ("Node", "create_node") or name.endswith((".Node", ".create_node")):
                yield part.lineno


def spins_bare(tree: ast.AST) -> Iterator[int]:
    """Yield the lines in which an executor is spun, or an executor made, without the guard."""
    for part in ast.walk(tree):
        if isinstance(part, ast.Attribute):
            name = ast.unparse(part)
            if name.endswith("executor.spin_once") or name.startswith("rclpy.spin"):
                yield part.lineno


def name_of(path: Path) -> str:
    return "/".join(path.relative_to(SOURCES).parts[1:])


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_a_module_makes_no_node_without_the_guard(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if name_of(path) not in GUARDS:
        assert not list(makes_bare_node(tree)), "make it of hitab_ros.guarded_node.GuardedNode"
    if name_of(path) not in SPINS:
        assert not list(spins_bare(tree)), "spin with hitab_ros.spinning.Spinner"


def test_the_check_finds_bare_nodes() -> None:
    bare = ast.parse(
        "import rclpy\nfrom rclpy.node import Node\nclass A(Node): pass\n"
        "rclpy.node.Node('a')\nrclpy.create_node('b')\nself.executor.spin_once(0.1)\n"
    )
    assert list(makes_bare_node(bare)) == [3, 4, 5]
    assert list(spins_bare(bare)) == [6]
