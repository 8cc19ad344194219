"""Lines of a swarm file and their keys; `swarm_description` shows a file.

    remap: {cmd_vel: /base/cmd_vel}     # names that the nodes of a line use: other names
    parameters: {max_speed: 0.5}        # of the nodes
    when_out_of_reach: halt             # while the commander or operator is silent, or go_on
    out_of_reach_after: 3.0             # s of silence
    use_sim_time: true                  # the nodes' clock is the topic /clock
    commanders:
      captain: {kind: Company, commands: [scout_1, scout_2, corporal]}   # one, over all of these
      corporal: {kind: Squad, commands: {scout: 1, carrier: 4}}          # as many as it takes
    kinds:
      Squad: {orders: ...}              # see hitab_commander.kinds.kind_reader
      Company: company.yaml             # or a file that describes the kind
    processes:
      relay: {module: hitab_robots.relay.velocity_relay, namespace: robot_1}
      lidar: {command: ros2 run ldlidar node, namespace: robot_1, remap: {scan: front/scan}}
    machines:                           # computers, the first of which runs what no other does
      desk: {runs: [world, captain]}    # a commander's name stands for all that it commands
      field: {runs: [corporal_2], ssh: ann@field.local, hosts: 2, takes_over: [desk]}

Processes are started, restarted and stopped with the agents, and each has a log.
"""

from __future__ import annotations

import importlib.util
import re
import shlex
import shutil
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, PlainValidator, model_validator

from hitab_bringup.swarm_files.swarm_description import AGENT_MARK, PACES, SIM_TIME
from hitab_commander import KindRecord
from hitab_core import VOCABULARY_NAME, VOCABULARY_NAME_RULE
from hitab_core.library.yaml_models import NONE_IS_EMPTY, Format, MappingOr, Record, Texts, among
from hitab_core.library.yaml_places import kind_of
from hitab_ros.names import WORLD

RESERVED = (
    *(WORLD, "hosts", "statuses", "commands", "alive", "operators"),
    *("distribution", "distribution_ack", "clock", "machines"),
)
SET = (
    *("commander", "superiors", "roles", "state_dir", "subordinates", "asks_position", "swarm"),
    "world",
)
"""Parameters of agents and worlds that a swarm sets by itself."""

OUT_OF_REACH = ("when_out_of_reach", "out_of_reach_after")
OWN_LINES = ("domain", "library", "behavior", "seed", "role", SIM_TIME, *OUT_OF_REACH)
"""Parameters of agents for which a line has keys."""

_PART = r"[A-Za-z_][A-Za-z0-9_]*"
_ROS_NAME = re.compile(rf"(~/|/)?{_PART}(/{_PART})*")


def _name(text: str) -> str:
    if VOCABULARY_NAME.match(text) is None:
        raise ValueError(f'"{text}" is not a name; {VOCABULARY_NAME_RULE}')
    return text


def _free(text: str) -> str:
    if text in RESERVED:
        raise ValueError("an agent cannot be called this; rename it")
    return text


def _free_machine(text: str) -> str:
    if text in RESERVED:
        raise ValueError("a machine cannot be called this; rename it")
    return text


def _destination(text: str) -> str:
    if re.fullmatch(r"([^\s-]\S*)?", text) is None:
        raise ValueError(
            f'"{text}" is not a destination for `ssh`, such as ann@lab2.local or a name in '
            "~/.ssh/config"
        )
    return text


def _command(text: str) -> str:
    if re.fullmatch(r"[\w./~+][\w./~+-]*", text) is None:
        raise ValueError(
            f'"{text}" is not the path of a command without spaces, such as ~/hitab/scripts/hitab'
        )
    return text


def _ros_name(text: str) -> str:
    if text in ("__ns", "__node", "__name"):
        raise ValueError(
            "cannot be remapped, since the swarm finds its nodes by name; leave it out, or write "
            "`namespace:`"
        )
    if _ROS_NAME.fullmatch(text.replace(AGENT_MARK, "agent")) is None:
        raise ValueError(f'"{text}" is not a name in ROS, such as cmd_vel or /base/scan')
    return text


def _namespace(text: str) -> str:
    return _ros_name(text.rstrip("/")) if text else ""


def _own(lines: tuple[str, ...], taken: tuple[str, ...]) -> AfterValidator:
    """Return a check that parameters are not set by a key of the line or by the swarm."""

    def check(name: str) -> str:
        if name in lines:
            raise ValueError("has a line of its own; move it out of the parameters")
        if name in taken:
            raise ValueError("is set by the swarm itself; leave it out")
        return name

    return AfterValidator(check)


def _plain(value: Any) -> Any:
    if isinstance(value, list | dict) or value is None:
        raise ValueError(f"must be a number, a text, true or false, not {kind_of(value)}")
    return value


def _parameter(value: Any) -> Any:
    """Return a parameter's value as nodes take it; lists become tuples."""
    if isinstance(value, dict):
        raise ValueError("has values inside; write each with its whole name, such as scan.yaw")
    if isinstance(value, bool | int | float | str):
        return value
    kinds = {type(item) for item in value or ()}
    if kinds == {int, float}:  # ROS has no lists of both
        return tuple(map(float, value))
    if len(kinds) != 1 or not kinds <= {bool, int, float, str}:
        raise ValueError(
            "must be a number, a text, true, false, or a list of equal kinds of these; leave it "
            "out to have the node's own default"
        )
    return tuple(value)


def _words(value: Any) -> tuple[str, ...]:
    if not isinstance(value, str):
        raise ValueError(f"must be a text, as in a terminal, not {kind_of(value)}")
    try:
        return tuple(shlex.split(value))
    except ValueError as error:
        raise ValueError(f"{error}; quote it as in a terminal") from None


def module_exists(module: str) -> bool:
    """Whether a Python module is installed."""
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        return False


def _installed(module: str) -> str:
    if module and not module_exists(module):
        raise ValueError(
            f"Python module {module} is not installed; install its package, or correct the name"
        )
    return module


def _program(words: tuple[str, ...]) -> tuple[str, ...]:
    if words and shutil.which(words[0]) is None:
        raise ValueError(
            f'there is no program "{words[0]}" on the PATH; install it, or name it with its folder'
        )
    return words


def _not_empty(value: Any) -> Any:
    if not value:
        raise ValueError("is empty; name its subordinates")
    return value


Value = Annotated[Any, PlainValidator(_parameter)]
Name = Annotated[str, AfterValidator(_name)]
AgentKey = Annotated[Name, AfterValidator(_free)]
MachineKey = Annotated[Name, AfterValidator(_free_machine)]
RosName = Annotated[str, AfterValidator(_ros_name)]
Namespace = Annotated[str, AfterValidator(_namespace)]
Seed = Annotated[int, Field(ge=0)]
Count = Annotated[int, Field(ge=1)]
Parameters = Annotated[dict[Annotated[str, _own(OWN_LINES, SET)], Value], NONE_IS_EMPTY]


class Renamed(Record):
    """ROS settings of the nodes of any line."""

    remap: Annotated[dict[RosName, RosName], NONE_IS_EMPTY] = Field(default_factory=dict)


class WorldLine(Renamed):
    """The world, which publishes the clock and cannot use it."""

    kind: str
    module: str = ""
    pace: Annotated[str, among(PACES)] = "realtime"
    factor: float = Field(default=1.0, gt=0.0)
    teaching: float = Field(default=0.5, ge=0.01, le=1.0)
    seed: Seed = 1
    paused: bool = False
    parameters: Annotated[dict[str, Annotated[Any, AfterValidator(_plain)]], NONE_IS_EMPTY] = (
        Field(default_factory=dict)
    )
    node_parameters: Annotated[
        dict[
            Annotated[str, _own(("pace", "factor", "teaching", "seed", "paused", SIM_TIME), SET)],
            Value,
        ],
        NONE_IS_EMPTY,
    ] = Field(default_factory=dict)


class Nodes(Renamed):
    """Settings of the nodes of any line except the world's."""

    use_sim_time: bool | None = None


class ReachLine(Record):
    """What members of the swarm do out of reach; `out_of_reach` says for whom a line holds."""

    when_out_of_reach: Annotated[str, among(("go_on", "halt"))] = "go_on"
    out_of_reach_after: float = Field(default=5.0, gt=0.0, le=3600.0)


class MemberSettings(Nodes, ReachLine):
    """Settings that agents and commanders have in common."""

    library: str = ""
    start_from: str = ""
    behavior: str = ""
    seed: Seed = 1
    parameters: Parameters = Field(default_factory=dict)


class AgentSettings(MemberSettings):
    """Settings for all agents of a file."""

    domain: str = ""


class AgentLine(AgentSettings):
    """One agent, or many."""

    count: Count | None = None
    per_process: Count | None = None
    host: str = ""
    role: str | None = None


class CommanderLine(MemberSettings):
    """One commander, or as many as needed if `commands` has counts."""

    kind: str
    commands: Annotated[
        dict[str, int] | tuple[str, ...],
        MappingOr(dict[str, Count], Texts),
        AfterValidator(_not_empty),
    ]
    host: str = ""
    role: str | None = None


class ProcessLine(Nodes):
    """A further process."""

    module: Annotated[str, AfterValidator(_installed)] = ""
    command: Annotated[tuple[str, ...], PlainValidator(_words), AfterValidator(_program)] = ()
    namespace: Namespace = ""
    parameters: Annotated[
        dict[Annotated[str, _own((SIM_TIME, "namespace"), ("swarm",))], Value], NONE_IS_EMPTY
    ] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _runs_one(self) -> Self:
        if bool(self.module) == bool(self.command):
            raise ValueError(
                "needs either `module:`, run with Python, or `command:`, and not both"
            )
        return self


class MachineLine(ReachLine):
    """A computer that runs part of the swarm."""

    runs: Texts = ()
    ssh: Annotated[str, AfterValidator(_destination)] = ""
    hitab: Annotated[str, AfterValidator(_command)] = "hitab"
    hosts: Count | None = None
    takes_over: Texts = ()


class SwarmLines(AgentSettings):
    """The whole file."""

    format: Format = 1
    swarm: Name = ""
    namespace: Namespace = ""
    world: WorldLine | None = None
    agents: Annotated[dict[AgentKey, AgentLine], NONE_IS_EMPTY] = Field(default_factory=dict)
    hosts: Count | None = None
    all_endpoints: bool | None = None
    kinds: Annotated[
        dict[Name, Annotated[KindRecord | str, MappingOr(KindRecord, str)]], NONE_IS_EMPTY
    ] = Field(default_factory=dict)
    commanders: Annotated[dict[AgentKey, CommanderLine], NONE_IS_EMPTY] = Field(
        default_factory=dict
    )
    processes: Annotated[dict[Name, ProcessLine], NONE_IS_EMPTY] = Field(default_factory=dict)
    machines: Annotated[dict[MachineKey, MachineLine], NONE_IS_EMPTY] = Field(default_factory=dict)
