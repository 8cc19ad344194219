"""Reads `processes:` of a swarm description: what else runs for a robot, such as its relay.

    processes:
      relay: {module: hitab_robots.velocity_relay, for: robot, parameters: {cmd_vel_timeout: 0.5}}
      lidar: {command: ros2 run ldlidar node, namespace: robot_1, remap: {scan: front/scan}}
      clock: {command: [my_clock, "10"]}

They are started, restarted and stopped with the agents, and each has a log. ``for`` names a line
of `agents:` and starts one for each of its agents, in the agent's namespace.
"""

from __future__ import annotations

import importlib.util
import shlex
import shutil
from collections.abc import Mapping, Sequence
from typing import Any

from hitab_bringup.ros_options import AGENT, SIM_TIME, RosOptions, read_namespace, read_options
from hitab_bringup.swarm_description import AgentDescription, ProcessDescription
from hitab_core import NAME, NAME_RULE, has
from hitab_core.library import Fields

ROS_WORDS = ("namespace", "remap", "parameters", SIM_TIME, "for")


def read_processes(
    top: Fields,
    above: RosOptions,
    groups: Mapping[str, Sequence[AgentDescription]],
    taken: Mapping[str, str],
) -> list[ProcessDescription]:
    """Read the further processes.

    Args:
        top: the top-level fields of the description.
        above: options for all nodes.
        groups: the agents by the key of their line.
        taken: names of other processes and agents, each with the section that names it.
    """
    section = top.inner("processes")
    owners = dict(taken)
    found = []
    for key in section.names():
        if not isinstance(key, str) or NAME.match(key) is None:
            section.complain(f'"{key}" is not a name for a process; {NAME_RULE}', key)
            continue
        fields = section.inner(key)
        agents = _agents(fields, groups)
        made = _line(fields, key, above, agents)
        fields.done()
        for process in made:
            if process.name in owners:
                fields.complain(
                    f'a second process "{process.name}" (see `{owners[process.name]}`); rename it'
                )
            owners[process.name] = key
        found += made
    return found


def _agents(
    fields: Fields, groups: Mapping[str, Sequence[AgentDescription]]
) -> list[AgentDescription] | None:
    """Return the agents that a line is for; None if it is not for agents."""
    name = fields.text("for", None)
    if name is None:
        return None
    if name not in groups:
        fields.complain(
            f'`for:` there is no line "{name}" under `agents:` {has(groups, name)}', "for"
        )
        return []
    return list(groups[name])


def _line(
    fields: Fields, key: str, above: RosOptions, agents: list[AgentDescription] | None
) -> list[ProcessDescription]:
    module, command = _what_runs(fields)
    arguments = fields.texts("arguments", ())
    # A program that is no ROS node takes no ROS arguments.
    is_node = bool(module) or any(word in fields for word in ROS_WORDS)
    namespace = read_namespace(fields, "" if agents is None else AGENT)
    options = read_options(fields, lines=(SIM_TIME, "namespace"), taken=("swarm",))
    options = options.over(above) if is_node else options

    def made(name: str, space: str, ros: RosOptions) -> ProcessDescription:
        return ProcessDescription(name, module, (*command, *arguments), space, ros, is_node)

    if agents is None:
        return [made(key, namespace, options)]
    return [
        made(f"{a.name}_{key}", namespace.replace(AGENT, a.name), options.of_agent(a.name))
        for a in agents
    ]


def _what_runs(fields: Fields) -> tuple[str, tuple[str, ...]]:
    """Return the module or the command of a line, and complain if it cannot be run."""
    module = fields.text("module", "")
    command = _words(fields, fields.raw("command", ""))
    if bool(module) == bool(command):
        fields.complain("needs either `module:`, run with Python, or `command:`, and not both")
    elif module and not module_exists(module):
        fields.complain(
            f"`module:` Python module {module} is not installed; install its package, or correct "
            "the name",
            "module",
        )
    elif command and shutil.which(command[0]) is None:
        fields.complain(
            f'`command:` there is no program "{command[0]}" on the PATH; install it, or name it '
            "with its folder",
            "command",
        )
    return module, command


def _words(fields: Fields, value: Any) -> tuple[str, ...]:
    if isinstance(value, str):
        try:
            return tuple(shlex.split(value))
        except ValueError as error:
            fields.complain(f"`command:` {error}; write it as a list of words", "command")
            return ()
    return tuple(fields.texts("command", ()))


def module_exists(module: str) -> bool:
    """Whether a Python module is installed."""
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        return False
