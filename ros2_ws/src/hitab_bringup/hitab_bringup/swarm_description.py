"""A swarm as its YAML description tells it: which agents, in which world, in which processes.

    swarm: keepaway
    domain: keepaway
    world: {kind: keepaway, pace: realtime, parameters: {taker_speed: 0.25}}
    start_from: ../libraries/keepaway
    behavior: Keepaway
    agents:
      keeper_1: {}
      keeper_2: {behavior: ""}     # anything above may be set for one agent alone
      scout: {count: 100, per_process: 50}   # scout_1 ... scout_100 in two processes

What stands above ``agents`` holds for all of them, so that a team of likes is short to write and
an unlike one just says where it differs.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from hitab_bringup.errors import DescriptionError
from hitab_bringup.names import WORLD
from hitab_bringup.suggest import did_you_mean
from hitab_bringup.yaml_fields import Fields
from hitab_core.errors import HitabError, has
from hitab_core.use import NAME, Use
from hitab_core.yaml_places import Complaints, read_yaml

PACES = ("lockstep", "realtime")
RESERVED = (WORLD, "distribution", "distribution_ack", "clock")


@dataclass(frozen=True)
class WorldDescription:
    """The world in which a swarm lives, if it is a simulated one.

    Attributes:
        kind: of world; its node is ``python -m <kind>_world.world_main`` unless ``module`` tells
            otherwise.
        pace: ``lockstep`` or ``realtime``, at ``factor`` of real time.
        parameters: of this kind of world, such as ``taker_speed``.
    """

    kind: str
    module: str
    pace: str = "realtime"
    factor: float = 1.0
    seed: int = 1
    paused: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class AgentDescription:
    """One agent.

    Attributes:
        library: its library folder; None: in the run folder, kept from run to run.
        start_from: a library that is copied into its own when that is empty.
        behavior: what it performs at first, such as ``Keepaway``; empty: nothing.
        process: name of the process in which it runs; its own name unless it shares one.
    """

    name: str
    domain: str
    library: Path | None = None
    start_from: Path | None = None
    behavior: str = ""
    seed: int = 1
    process: str = ""


@dataclass(frozen=True)
class SwarmDescription:
    """A whole swarm."""

    name: str
    file: Path
    agents: tuple[AgentDescription, ...]
    world: WorldDescription | None = None

    @property
    def agent_names(self) -> tuple[str, ...]:
        """The names of all agents."""
        return tuple(agent.name for agent in self.agents)

    def with_world(self, **changes: Any) -> SwarmDescription:
        """Return the same swarm in a world that differs."""
        if self.world is None:
            raise DescriptionError(f'{self.file}: swarm "{self.name}" has no `world:`')
        return replace(self, world=replace(self.world, **changes))

    def with_agents(self, **changes: Any) -> SwarmDescription:
        """Return the same swarm with something changed in all agents."""
        return replace(self, agents=tuple(replace(a, **changes) for a in self.agents))


def read_swarm(path: Path) -> SwarmDescription:
    """Read a swarm description.

    Raises:
        DescriptionError: with everything that is wrong, by file and line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DescriptionError(f"{path}: cannot be read: {error}") from None
    return parse_swarm(text, path)


def parse_swarm(text: str, path: Path) -> SwarmDescription:
    """Read a swarm description from its text; ``path`` is where relative paths begin."""
    document = read_yaml(text, str(path), error=DescriptionError)
    complaints = Complaints(document, DescriptionError)
    top = Fields(document, complaints)
    name = top.text("swarm", path.stem)
    _check_name(top, name, "swarm")
    world = _world(top) if "world" in top else None
    common = _Common.of(top, path.parent)
    agents = _agents(top, common, path.parent)
    top.done()
    complaints.raise_any()
    return SwarmDescription(name, path, tuple(agents), world)


def _world(top: Fields) -> WorldDescription:
    fields = top.inner("world")
    kind = fields.text("kind") or ""
    module = fields.text("module", f"{kind}_world.world_main")
    world = WorldDescription(
        kind,
        module,
        fields.text("pace", "realtime", among=PACES),
        fields.number("factor", 1.0, above=0.0),
        fields.integer("seed", 1, least=0),
        fields.flag("paused", False),
        _scalars(fields.inner("parameters")),
    )
    fields.done()
    if kind and not _module_exists(module):
        fields.complain(
            f'there is no world "{kind}": Python module {module} is not installed; install its '
            "package, or name the module with `module:`",
            "kind",
        )
    return world


def _scalars(fields: Fields) -> dict[str, Any]:
    found = {}
    for key in fields.names():
        value = fields.raw(key)
        if isinstance(value, list | dict) or value is None:
            fields.complain(f"`{key}:` must be a number, a text, true or false", key)
        else:
            found[key] = value
    return found


def _module_exists(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        return False


@dataclass(frozen=True)
class _Common:
    """What may be said for all agents, or for one."""

    domain: str = ""
    library: str = ""
    start_from: str = ""
    behavior: str = ""
    seed: int = 1

    @classmethod
    def of(cls, fields: Fields, base: Path, above: _Common | None = None) -> _Common:
        above = above or cls()
        found = cls(
            fields.text("domain", above.domain),
            fields.text("library", above.library),
            fields.text("start_from", above.start_from),
            fields.text("behavior", above.behavior),
            fields.integer("seed", above.seed, least=0),
        )
        if found.behavior != above.behavior:
            try:
                if found.behavior:
                    Use.parse(found.behavior)
            except HitabError as error:
                fields.complain(str(error), "behavior")
        if found.start_from != above.start_from and not (base / found.start_from).is_dir():
            fields.complain(
                f'`start_from:` there is no library folder "{found.start_from}"; correct the '
                "path, which begins at this file, or leave it out to begin with nothing",
                "start_from",
            )
        own = found.library != above.library and "{agent}" not in found.library
        if own and not (base / found.library).is_dir():
            fields.complain(
                f'`library:` there is no folder "{found.library}"; make it, or leave '
                "`library` out and each agent has its own in the run folder",
                "library",
            )
        return found


def _agents(top: Fields, common: _Common, base: Path) -> list[AgentDescription]:
    group = top.inner("agents")
    agents: list[AgentDescription] = []
    owners: dict[str, str] = {}
    if "agents" not in top or not group.names():
        top.complain("a swarm needs `agents:`, a line with a name each")
    domains: dict[str, Any] = {}
    for key in group.names():
        fields = group.inner(key)
        _check_name(group, key, "agent", key)
        own = _Common.of(fields, base, common)
        count = fields.integer("count", None, least=1)
        per_process = fields.integer("per_process", 1, least=1)
        host = fields.text("host", "")
        fields.done()
        _check_domain(fields, own.domain, domains)
        names = [key] if count is None else [f"{key}_{i + 1}" for i in range(count)]
        for index, name in enumerate(names):
            if name in owners:
                fields.complain(f'a second agent "{name}" (see `{owners[name]}`); rename one')
            owners[name] = key
            process = host or (
                name if per_process == 1 else f"{key}_host_{index // per_process + 1}"
            )
            agents.append(
                AgentDescription(
                    name,
                    own.domain,
                    base / own.library.format(agent=name) if own.library else None,
                    base / own.start_from if own.start_from else None,
                    own.behavior,
                    own.seed,
                    process,
                )
            )
    return agents


def _check_name(fields: Fields, name: Any, what: str, *inner: str) -> None:
    if not isinstance(name, str) or NAME.match(name) is None:
        fields.complain(f'"{name}" is not a name for a {what}; use letters, digits and _', *inner)
    elif what == "agent" and name in RESERVED:
        fields.complain(f'an agent cannot be called "{name}"; rename it', *inner)


def _check_domain(fields: Fields, name: str, known: dict[str, Any]) -> None:
    from importlib.metadata import entry_points

    from hitab_core.domain import ENTRY_POINT_GROUP

    if not known:
        known.update({point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)})
    if not name:
        fields.complain(f"`domain:` is missing, for this agent or for all {has(known)}")
    elif name not in known:
        fields.complain(
            f'no domain "{name}" is installed {has(known)}{did_you_mean(name, known)}',
            *(["domain"] if "domain" in fields else []),
        )
