"""Reads a swarm file: YAML that describes a swarm; see `hitab_bringup.swarm_description`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from hitab_bringup.command_tree import in_hosts, with_positions_asked, with_superiors
from hitab_bringup.commander_section import CommanderSection, Line, read_kinds
from hitab_bringup.process_section import module_exists, read_processes
from hitab_bringup.ros_options import (
    AGENT,
    SIM_TIME,
    RosOptions,
    read_namespace,
    read_options,
)
from hitab_bringup.swarm_description import (
    PACES,
    AgentDescription,
    CommanderDescription,
    SwarmDescription,
    WorldDescription,
)
from hitab_bringup.swarm_words import Words
from hitab_client import DescriptionError
from hitab_client.run_folder import state_home
from hitab_commander import CommanderKind
from hitab_core import NAME, NAME_RULE, has
from hitab_core.library import SUFFIX, Fields
from hitab_core.library.yaml_places import Complaints, read_text, read_yaml
from hitab_ros.names import WORLD

FORMAT = 2
"""The newest format version that is read."""

RESERVED = (WORLD, "hosts", "distribution", "distribution_ack", "clock")
WORLDS = "hitab.worlds"
OWN_LINES = ("domain", "library", "behavior", "seed", "without", "role", SIM_TIME)
"""Parameters of agents that a line of a description has keys for."""

SET = {"commander", "roles", "state_dir", "subordinates", "asks_position", "swarm", "world"}
"""Parameters of agents and worlds that a swarm sets by itself."""


def read_swarm(path: Path, run_dir: Path | None = None) -> SwarmDescription:
    """Read a swarm description.

    Args:
        path: of its file.
        run_dir: its run folder, unless that is the default one.

    Raises:
        DescriptionError: naming everything that is wrong, by file and line.
    """
    if path.name.endswith(SUFFIX):
        raise DescriptionError(f"{path}: this is the file of a behavior, not a swarm file")
    return parse_swarm(read_text(path, error=DescriptionError), path, run_dir)


def parse_swarm(text: str, path: Path, run_dir: Path | None = None) -> SwarmDescription:
    r"""Read a swarm description from its text; relative paths start at the folder of ``path``.

    Raises:
        DescriptionError: naming each line that is wrong.

    Examples:
        >>> text = "swarm: pair\ndomain: keepaway\nagents:\n  keeper: {count: 2}\n"
        >>> [agent.name for agent in parse_swarm(text, Path("pair.yaml")).agents]
        ['keeper_1', 'keeper_2']
    """
    document = read_yaml(text, str(path), error=DescriptionError)
    top = Fields(Complaints(document, DescriptionError))
    top.check_format(FORMAT)
    name = top.text("swarm", path.stem)
    _check_name(top, name, "a swarm")
    namespace = read_namespace(top)
    world = _world(top) if "world" in top else None
    common = _Common.of(top, path.parent)
    # In a namespace its name, and so its run folder's, is longer.
    runs = (run_dir,) if run_dir is not None else state_home().glob(f"{name}*")
    kept = (file for run in runs for file in run.glob(f"libraries/*/*{SUFFIX}"))
    words = Words(top, frozenset(file.name.removesuffix(SUFFIX) for file in kept))
    hosts = top.integer("hosts", None, least=1)
    groups = _agents(top, common, path.parent, words, hosts is not None)
    commanders = _commanders(top, common, path.parent, words, groups, hosts is not None)
    agents = [agent for group in groups.values() for agent in group]
    if hosts is not None and not top.complaints:
        agents, commanders = in_hosts(agents, commanders, hosts)
    taken = {WORLD: "world"} if world is not None else {}
    taken |= {m.process: m.name for m in (*agents, *commanders)}
    taken |= {m.name: m.name for m in (*agents, *commanders)}
    processes = read_processes(top, common.ros.without_parameters(), groups, taken)
    top.done(name="swarm")
    top.complaints.raise_any()
    if world is not None:
        above = replace(common.ros.without_parameters(), use_sim_time=None)
        world = replace(world, ros=world.ros.over(above))
    return SwarmDescription(
        name,
        path,
        tuple(_with_libraries(agents, groups)),
        world,
        tuple(commanders),
        f"/{namespace.strip('/')}" if namespace else "",
        tuple(processes),
    )


def _world(top: Fields) -> WorldDescription:
    fields = top.inner("world")
    kind = fields.text("kind") or ""
    module = fields.text("module", world_module(kind))
    world = WorldDescription(
        kind,
        module,
        fields.text("pace", "realtime", among=PACES),
        fields.number("factor", 1.0, above=0.0),
        fields.integer("seed", 1, least=0),
        fields.flag("paused", False),
        _scalars(fields.inner("parameters")),
        read_options(
            fields,
            key="node_parameters",
            lines=("pace", "factor", "seed", "paused", SIM_TIME),
            taken=SET,
        ),
    )
    if world.ros.use_sim_time:
        fields.complain(
            "the world makes the clock and cannot wait for it; write `use_sim_time:` at the top "
            "of the file, for all others",
            SIM_TIME,
        )
    fields.done()
    if kind and not module_exists(module):
        fields.complain(
            f'unknown world "{kind}": Python module {module} is not installed; install its '
            "package, or name the module with `module:`",
            "kind",
        )
    return world


def world_module(kind: str) -> str:
    """Return the module that runs worlds of a kind.

    A package registers its own under the entry-point group ``hitab.worlds``; the default is
    ``<kind>_world.world_main``.
    """
    told = entry_points(group=WORLDS, name=kind)
    return next((point.value for point in told), f"{kind}_world.world_main")


def _scalars(fields: Fields) -> dict[str, Any]:
    found = {}
    for key in fields.names():
        value = fields.raw(key)
        if isinstance(value, list | dict) or value is None:
            fields.complain(f"`{key}:` must be a number, a text, true or false", key)
        else:
            found[key] = value
    return found


@dataclass(frozen=True)
class _Common:
    """Settings for all agents, or for one."""

    domain: str = ""
    library: str = ""
    start_from: str = ""
    behavior: str = ""
    seed: int = 1
    without: tuple[str, ...] = ()
    ros: RosOptions = field(default_factory=RosOptions)

    @classmethod
    def of(cls, fields: Fields, base: Path, above: _Common | None = None) -> _Common:
        above = above or cls()
        found = cls(
            fields.text("domain", above.domain),
            fields.text("library", above.library),
            fields.text("start_from", above.start_from),
            fields.text("behavior", above.behavior),
            fields.integer("seed", above.seed, least=0),
            fields.texts("without", above.without),
            read_options(fields, lines=OWN_LINES, taken=SET).over(above.ros),
        )
        if found.start_from != above.start_from and not (base / found.start_from).is_dir():
            fields.complain(
                f'`start_from:` there is no library folder "{found.start_from}"; correct the '
                "path, which is relative to this file, or leave it out to start empty",
                "start_from",
            )
        own = found.library != above.library and AGENT not in found.library
        if own and not (base / found.library).is_dir():
            fields.complain(
                f'`library:` there is no folder "{found.library}"; make it, or leave '
                "`library` out to give each agent its own in the run folder",
                "library",
            )
        return found

    def libraries(self, base: Path) -> list[Path]:
        """Return the folders known to hold trained behaviors."""
        named = [text for text in (self.library, self.start_from) if text and AGENT not in text]
        return [base / text for text in named]


Groups = dict[str, list[AgentDescription]]
"""The agents by the key of their line."""


def _agents(top: Fields, common: _Common, base: Path, words: Words, hosted: bool) -> Groups:
    section = top.inner("agents")
    groups: Groups = {}
    owners: dict[str, str] = {}
    if not top.raw("agents", None):
        top.complain("a swarm needs `agents:`, a mapping with one line per agent")
    for key in section.names():
        fields = section.inner(key)
        _check_name(section, key, "an agent", key)
        own = _Common.of(fields, base, common)
        count = fields.integer("count", None, least=1)
        per_process = fields.integer("per_process", None, least=1)
        host = fields.text("host", "")
        role = fields.text("role", key)
        fields.done()
        words.check_domain(fields, own.domain)
        words.check_without(fields, own.domain, own.without)
        if own.behavior:
            words.check_behavior(fields, own.domain, own.behavior, own.libraries(base))
        names = [key] if count is None else [f"{key}_{i + 1}" for i in range(count)]
        groups[key] = []
        for index, name in enumerate(names):
            if name in owners:
                fields.complain(f'a second agent "{name}" (see `{owners[name]}`); rename one')
            owners[name] = key
            process = host
            if not host and per_process not in (None, 1):
                process = f"{key}_host_{index // per_process + 1}"
            elif not host and not (hosted and per_process is None):
                process = name
            groups[key].append(
                AgentDescription(
                    name,
                    own.domain,
                    base / own.library.replace(AGENT, name) if own.library else None,
                    base / own.start_from if own.start_from else None,
                    own.behavior,
                    own.seed,
                    process,
                    role=role,
                    without=own.without,
                    ros=own.ros.of_agent(name),
                )
            )
    return groups


def _commanders(
    top: Fields, common: _Common, base: Path, words: Words, groups: Groups, hosted: bool
) -> list[CommanderDescription]:
    """Read the commanders and set the superiors of their subordinates in ``groups``."""
    kinds = read_kinds(top, base)
    section = top.inner("commanders")
    tree = CommanderSection(groups, words)
    lines: dict[str, Line] = {}
    agents = {agent.name: key for key, group in groups.items() for agent in group}
    # Settings for all agents do not apply to commanders, except the seed and those of all nodes.
    above = _Common(seed=common.seed, ros=common.ros.without_parameters())
    for key in section.names():
        fields = section.inner(key)
        _check_name(section, key, "an agent", key)
        if key in groups or key in agents:
            fields.complain(f'a second "{key}" (see `agents:`); rename one')
        own = _Common.of(fields, base, above)
        if own.domain:
            fields.complain("a commander's domain is its kind; write `kind:`", "domain")
        if own.without:
            fields.complain(
                "a commander has no hand-written automata to take out; leave `without:` away here",
                "without",
            )
        counts, names = tree.read_commands(fields)
        host, role = fields.text("host", ""), fields.text("role", key)
        lines[key] = Line(
            fields,
            _commander_maker(own, base, "" if hosted else None, host, role),
            _kind(fields, kinds),
            counts,
            names,
        )
        fields.done()
    commanders, superiors = tree.resolve(lines)
    names_taken = set(agents)
    for commander in commanders:
        if commander.name in names_taken:
            section.complain(f'a second "{commander.name}"; rename one')
        names_taken.add(commander.name)
        line = next(k for k in lines if k == commander.name or _is_one_of(commander.name, k))
        words.check_commander(lines[line].fields, commander)
    for key, group in groups.items():
        groups[key] = with_superiors(group, superiors)
    commanders = with_superiors(commanders, superiors)
    return [
        replace(c, domain=c.kind.name, library_name=c.kind.name)
        for c in with_positions_asked(commanders)
    ]


def _commander_maker(
    own: _Common, base: Path, shared: str | None, host: str, role: str
) -> Callable[[str], CommanderDescription]:
    """Return a factory for the commanders of a line; ``shared``: their process, if shared."""

    def make(name: str) -> CommanderDescription:
        return CommanderDescription(
            name,
            "",
            base / own.library.replace(AGENT, name) if own.library else None,
            base / own.start_from if own.start_from else None,
            own.behavior,
            own.seed,
            host or (name if shared is None else shared),
            role=role,
            ros=own.ros.of_agent(name),
        )

    return make


def _is_one_of(name: str, key: str) -> bool:
    return name.startswith(f"{key}_") and name[len(key) + 1 :].isdigit()


def _kind(fields: Fields, kinds: Mapping[str, CommanderKind]) -> CommanderKind | None:
    name = fields.text("kind")
    if name is not None and name not in kinds:
        fields.complain(
            f'there is no kind "{name}" under `kinds:` {has(kinds, name)}',
            "kind",
        )
    return kinds.get(name)


def _with_libraries(
    agents: Sequence[AgentDescription], groups: Groups
) -> Iterator[AgentDescription]:
    """Name library folders: equal agents in a process share one."""
    keys = {agent.name: key for key, group in groups.items() for agent in group}
    inside: dict[str, set[str]] = {}
    for agent in agents:
        inside.setdefault(agent.process, set()).add(keys[agent.name])
    for agent in agents:
        alone = len(inside[agent.process]) == 1
        name = "" if alone else f"{agent.process}_{keys[agent.name]}"
        yield replace(agent, library_name=name)


def _check_name(fields: Fields, name: Any, what: str, *inner: str) -> None:
    if not isinstance(name, str) or NAME.match(name) is None:
        fields.complain(f'"{name}" is not a name for {what}; {NAME_RULE}', *inner)
    elif what == "an agent" and name in RESERVED:
        fields.complain(f'an agent cannot be called "{name}"; rename it', *inner)
