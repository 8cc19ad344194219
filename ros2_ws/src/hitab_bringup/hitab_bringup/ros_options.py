"""What a line of a swarm description says about its nodes in words of ROS.

remap: {cmd_vel: /base/cmd_vel}     # names that the nodes use: other names
parameters: {max_speed: 0.5}        # of the nodes
use_sim_time: true                  # the nodes' clock is the topic /clock
"""

from __future__ import annotations

import re
from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import Any

from hitab_core.library import Fields

AGENT = "{agent}"
"""Placeholder for the agent's name, in names and texts."""

CLOCK = "/clock"
SIM_TIME = "use_sim_time"

_PART = r"[A-Za-z_][A-Za-z0-9_]*"
_NAME = re.compile(rf"(~/|/)?{_PART}(/{_PART})*")
_WRITTEN_OTHERWISE = {"__ns": "namespace", "__node": "", "__name": ""}


@dataclass(frozen=True)
class RosOptions:
    """Remappings and parameters of nodes.

    Attributes:
        remap: the names that nodes use, each with the one to use instead.
        parameters: by name; a nested one has dots in its name.
        use_sim_time: whether the nodes' clock is the topic ``/clock``; None: not said.
    """

    remap: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    use_sim_time: bool | None = None

    def over(self, above: RosOptions) -> RosOptions:
        """Return these options, completed by those that hold for more nodes."""
        return RosOptions(
            {**above.remap, **self.remap},
            {**above.parameters, **self.parameters},
            above.use_sim_time if self.use_sim_time is None else self.use_sim_time,
        )

    def of_agent(self, agent: str) -> RosOptions:
        """Return the same with an agent's name in place of ``{agent}``."""
        return RosOptions(
            {_named(name, agent): _named(other, agent) for name, other in self.remap.items()},
            {name: _named(value, agent) for name, value in self.parameters.items()},
            self.use_sim_time,
        )

    def without_parameters(self) -> RosOptions:
        """Return the same for nodes of another kind, whose parameters are others."""
        return RosOptions(self.remap, {}, self.use_sim_time)

    @property
    def all_parameters(self) -> dict[str, Any]:
        """The parameters, with that of the clock if it was given."""
        given = {} if self.use_sim_time is None else {SIM_TIME: self.use_sim_time}
        return {**self.parameters, **given}


def _named(value: Any, agent: str) -> Any:
    if isinstance(value, str):
        return value.replace(AGENT, agent)
    if isinstance(value, tuple):
        return tuple(_named(item, agent) for item in value)
    return value


def read_options(
    fields: Fields,
    *,
    key: str = "parameters",
    lines: Container[str] = (),
    taken: Container[str] = (),
) -> RosOptions:
    """Read the ROS options of a line.

    Args:
        fields: of the line.
        key: of the parameters.
        lines: parameters that have a key of their own in the line.
        taken: parameters that the swarm itself sets.
    """
    return RosOptions(
        read_remap(fields),
        _parameters(fields.inner(key), lines, taken),
        fields.flag(SIM_TIME, None),
    )


def read_remap(fields: Fields) -> dict[str, str]:
    """Read ``remap:``."""
    section = fields.inner("remap")
    found = {}
    for name in section.names():
        other = section.raw(name)
        if name in _WRITTEN_OTHERWISE:
            instead = _WRITTEN_OTHERWISE[name]
            section.complain(
                f"`{name}:` cannot be remapped here, since the swarm finds its nodes by name; "
                + (f"write `{instead}:`" if instead else "leave it out"),
                name,
            )
        elif not _is_name(name):
            section.complain(
                f'"{name}" is not the name of a topic or service, such as cmd_vel or /scan', name
            )
        elif not _is_name(other):
            section.complain(
                f"`{name}:` needs the name to use instead, such as /base/{name.strip('~/')}", name
            )
        else:
            found[name] = other
    return found


def _is_name(name: Any) -> bool:
    return isinstance(name, str) and _NAME.fullmatch(name.replace(AGENT, "agent")) is not None


def read_namespace(fields: Fields, default: str = "", *, key: str = "namespace") -> str:
    """Read a namespace, without a slash at its end."""
    text = fields.text(key, default)
    if text and not _is_name(text.rstrip("/")):
        fields.complain(
            f'`{key}:` "{text}" is not a namespace; use letters, digits and _, not beginning '
            "with a digit, such as left",
            key,
        )
        return default
    return (text or "").rstrip("/")


def _parameters(
    section: Fields, lines: Container[str], taken: Container[str], before: str = ""
) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key in section.names():
        name = f"{before}{key}"
        value = section.raw(key)
        if name in lines:
            section.complain(
                f"`{name}:` has a line of its own; move it out of the parameters", key
            )
        elif name in taken:
            section.complain(f"`{name}:` is set by the swarm itself; leave it out", key)
        elif isinstance(value, dict):
            found |= _parameters(section.inner(key), lines, taken, f"{name}.")
        elif (listed := _value(value)) is None:
            section.complain(
                f"`{key}:` must be a number, a text, true, false, or a list of equal kinds of "
                "these; leave it out to have the node's own default",
                key,
            )
        else:
            found[name] = listed
    return found


def _value(value: Any) -> Any:
    """Return the value of a parameter; None if it cannot be one."""
    if isinstance(value, bool | int | float | str):
        return value
    if not isinstance(value, list) or not value:
        return None
    kinds = {type(item) for item in value}
    if kinds == {int, float}:  # ROS has no lists of both
        return tuple(map(float, value))
    return tuple(value) if len(kinds) == 1 and kinds <= {bool, int, float, str} else None
