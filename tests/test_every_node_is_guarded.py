"""No node can forget the guard: each is a `GuardedNode`, and each executor is spun guarded.

A node made otherwise, or an executor spun otherwise, ends its process at the first exception that
a callback raises.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

SOURCES = Path(__file__).parents[1] / "ros2_ws" / "src"
MODULES = sorted(
    path for package in SOURCES.glob("*/*/__init__.py") for path in package.parent.rglob("*.py")
)
GUARDS = {"hitab_ros/nodes/guarded_node.py"}  # where the guarded node is made of a bare one
SPINS = {
    "hitab_ros/nodes/spinning.py",  # the guarded spin
    "hitab_client/connecting/ros_link.py",  # what a subscriber raises is for the command
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


def test_no_module_makes_a_node_without_the_guard() -> None:
    assert MODULES
    trees = {name_of(path): ast.parse(path.read_text(encoding="utf-8")) for path in MODULES}
    bare = {n: list(makes_bare_node(tree)) for n, tree in trees.items() if n not in GUARDS}
    spun = {n: list(spins_bare(tree)) for n, tree in trees.items() if n not in SPINS}
    found = {name: lines for name, lines in bare.items() if lines}
    assert found == {}, "make it of hitab_ros.nodes.guarded_node.GuardedNode"
    found = {name: lines for name, lines in spun.items() if lines}
    assert found == {}, "spin with hitab_ros.nodes.spinning.Spinner"
