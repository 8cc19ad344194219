"""Verb that writes the files of a new robot or world: new."""

from __future__ import annotations

import re
from importlib.metadata import entry_points
from importlib.util import find_spec
from keyword import iskeyword
from pathlib import Path
from typing import Annotated

import typer

from hitab_client import console
from hitab_client.terminal.cli_remedies import called
from hitab_core import ENTRY_POINT_GROUP, HitabError

TEMPLATES = Path(__file__).parents[2] / "templates"
TEMPLATE_SUFFIX = ".txt"
"""Suffix that keeps templates from being compiled, tested or installed as code."""
PACKAGE_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", re.ASCII)


def new(
    name: str,
    world: Annotated[bool, typer.Option("--world")] = False,
    standard: Annotated[bool, typer.Option("--standard")] = False,
) -> None:
    """Write the files of a new robot, or with --world of a simulated world in one file.

    The new files can be started, tested and trained at once; then change them.

    Args:
        name: Of the folder my_robot, or the file my_world.py; neither may exist yet.
        world: Write a world in one file instead of a robot's package.
        standard: The robot has standard messages: odometry, a scanner and velocities. It can be
            tested at once, and started beside its driver.

    Examples:
      hitab new my_robot
      hitab new my_robot --standard
      hitab new my_world --world
    """
    kind = "world" if world else "robot"
    placeholder = f"my_{kind}"
    _refuse_taken(name, placeholder)
    to = Path(f"{name}.py" if world else name)
    if world and standard:
        raise typer.BadParameter("--standard is for a robot; leave out --world")
    if to.exists() or to.is_symlink():
        raise HitabError(f"{to} exists already; choose another name, or another folder")
    own = TEMPLATES / ("standard" if standard else kind)
    for base in (own,) if world else (own, TEMPLATES / "package"):
        for template in sorted(base.rglob(f"*{TEMPLATE_SUFFIX}")):
            path = str(template.relative_to(base)).removesuffix(TEMPLATE_SUFFIX)
            file = to if world else to / path.replace(placeholder, name)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(template.read_text("utf-8").replace(placeholder, name), "utf-8")
    hitab = called()
    if world:
        console.say(
            f"wrote {to}; start it: {hitab} up {to}; test it (pip install pytest): pytest {to}"
        )
        return
    driver = "" if standard else f", its driver in {name}/link.py"
    console.say(f"wrote {to}/; its words are in {name}/domain.py{driver}")
    console.say(f"install it: pip install --no-build-isolation --no-deps -e ./{to}")
    console.say(f"start it: {hitab} up {to}/swarm.yaml")
    console.say(f"let it act, after each start and each stop: {hitab} arm robot_1")
    console.say(f"test it (pip install pytest): pytest {to}")


def _refuse_taken(name: str, example: str) -> None:
    """Refuse a name that Python, ROS or an installed package uses for something else."""
    if PACKAGE_NAME.fullmatch(name) is None or len(name) < 2 or iskeyword(name):
        raise HitabError(
            f'"{name}" is not a name for a package; use small letters, digits and single "_", '
            f"beginning with a letter, such as {example}"
        )
    points = {point.name for point in entry_points(group=ENTRY_POINT_GROUP)}
    found = find_spec(name)
    # A folder without code, such as an existing one here, is no package.
    if name in points or (found is not None and found.origin is not None):
        raise HitabError(f'"{name}" is the name of a package that is installed; choose another')
