"""Reader of swarm files: YAML that describes a swarm; see `swarm_description`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, TypeVar

from hitab_bringup.libraries.library_choice import known_libraries
from hitab_bringup.swarm_files.commander_tree import CommanderTree, in_hosts
from hitab_bringup.swarm_files.machine_plan import MachinePlan
from hitab_bringup.swarm_files.out_of_reach import with_reach
from hitab_bringup.swarm_files.swarm_description import (
    AGENT_MARK,
    SIM_TIME,
    AgentDescription,
    CommanderDescription,
    Process,
    SwarmDescription,
    WorldDescription,
)
from hitab_bringup.swarm_files.swarm_lines import (
    AgentLine,
    CommanderLine,
    MemberSettings,
    Nodes,
    ProcessLine,
    ReachLine,
    SwarmLines,
    WorldLine,
    module_exists,
)
from hitab_bringup.swarm_files.swarm_vocabulary import SwarmVocabulary
from hitab_client import DescriptionError
from hitab_client.runs.run_folder import state_home
from hitab_commander import CommanderKind, KindRecord, kind_in, read_kind
from hitab_commander.commander_domain import commander_domain
from hitab_core import HitabError, has
from hitab_core.library import BEHAVIOR_SUFFIX
from hitab_core.library.yaml_models import open_record
from hitab_core.library.yaml_places import Complaints, open_yaml, read_text, read_yaml
from hitab_ros.names import WORLD

FORMAT = 2
"""The newest format version that is read."""

WORLDS = "hitab.worlds"
PYTHON_SUFFIX = ".py"
"""Suffix of a world in one file, which also has its agents' vocabulary."""

NODES = {"remap", SIM_TIME}
MEMBERS = {*NODES, "library", "start_from", "behavior", "seed", "parameters", "domain"}
ROS_WORDS = {*NODES, "namespace", "parameters"}
"""Keys that make a process a ROS node; other programs take no ROS arguments."""

L = TypeVar("L", bound=Nodes)


def read_swarm(path: Path, run_dir: Path | None = None) -> SwarmDescription:
    """Read a swarm description.

    Args:
        path: path of the file.
        run_dir: run folder of the swarm; None for the default one.

    Raises:
        DescriptionError: if the file is invalid; names all faults by file and line.
    """
    if path.name.endswith(BEHAVIOR_SUFFIX):
        raise DescriptionError(f"{path}: this is the file of a behavior, not a swarm file")
    return parse_swarm(read_text(path, error=DescriptionError), path, run_dir)


def parse_swarm(text: str, path: Path, run_dir: Path | None = None) -> SwarmDescription:
    r"""Read a swarm description from its text; relative paths start at the folder of ``path``.

    Raises:
        DescriptionError: if the text is invalid; names each wrong line.

    Examples:
        >>> text = "swarm: pair\ndomain: keepaway\nagents:\n  keeper: {count: 2}\n"
        >>> [agent.name for agent in parse_swarm(text, Path("pair.yaml")).agents]
        ['keeper_1', 'keeper_2']
    """
    document = read_yaml(text, str(path), error=DescriptionError)
    file = open_record(SwarmLines, document, FORMAT)
    name = file.swarm or path.stem
    # In a namespace, the swarm's name and its run folder's are longer.
    runs = (run_dir,) if run_dir is not None else state_home().glob(f"{name}*")
    kept = (file for run in runs for file in run.glob(f"libraries/*/*{BEHAVIOR_SUFFIX}"))
    words = SwarmVocabulary(frozenset(file.name.removesuffix(BEHAVIOR_SUFFIX) for file in kept))
    return _Reader(file, Complaints(document), path, words).swarm(name)


def parameter_places(path: Path, name: str) -> list[str]:
    """Return the lines of a swarm file, as ``file:line``, that set a parameter of nodes."""
    if path.suffix == PYTHON_SUFFIX:  # only a world
        return []
    document = open_yaml(path, error=DescriptionError)
    end = ("parameters", *name.removeprefix("parameters.").split("."))
    return [document.place(place) for place in document.lines if place[-len(end) :] == end]


def world_module(kind: str) -> str:
    """Return the module that runs worlds of a kind.

    Packages register modules under the entry-point group ``hitab.worlds``; the default is
    ``<kind>_world.world_main``.
    """
    registered = entry_points(group=WORLDS, name=kind)
    return next((point.value for point in registered), f"{kind}_world.world_main")


def _under(above: Nodes, line: L, keys: set[str]) -> L:
    """Return a line completed by the settings for all; the line's own keys stay marked as set."""
    missing = (above.model_fields_set & keys) - line.model_fields_set
    more: dict[str, Any] = {key: getattr(above, key) for key in missing}
    for key in {"remap", "parameters"} & keys:
        more[key] = {**getattr(above, key), **getattr(line, key)}
    return line.but(**more)


def _ros(line: MemberSettings | ProcessLine, agent: str = AGENT_MARK) -> dict[str, Any]:
    """Return the remappings and parameters of a line; an agent's name replaces ``{agent}``."""

    def named(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(named, value))
        return value.replace(AGENT_MARK, agent) if isinstance(value, str) else value

    clock = {} if line.use_sim_time is None else {SIM_TIME: line.use_sim_time}
    return {
        "remap": {named(name): named(other) for name, other in line.remap.items()},
        "parameters": {name: named(value) for name, value in line.parameters.items()} | clock,
    }


class _Reader:
    """Builder of a swarm from the lines of a file; collects complaints about conflicts."""

    def __init__(
        self, file: SwarmLines, complaints: Complaints, path: Path, words: SwarmVocabulary
    ) -> None:
        self._file = file
        self._complaints = complaints
        self._path = path
        self._words = words
        self._owners = {} if file.world is None else {WORLD: WORLD}

    def swarm(self, name: str) -> SwarmDescription:
        """Return the swarm.

        Raises:
            DescriptionError: with all complaints.
        """
        file = self._file
        if not file.agents:
            self._complaints.add((), "a swarm needs `agents:`, a mapping with one line per agent")
        world = self._world(file.world) if file.world is not None else None
        self._check_folders(file)
        groups = self._agents()
        tree = CommanderTree(
            groups, file.commanders, self._kinds(), self._commander, self._words, self._tell
        )
        lines = self._commanders(tree)
        commanders = [c for group in lines.values() for c in group]
        groups = {key: tree.with_superiors(group) for key, group in groups.items()}
        agents = [agent for group in groups.values() for agent in group]
        if self._world_file:
            names = {f"agent_{i + 1}" for i in range(len(agents))}
            if names != {agent.name for agent in agents}:
                text = "of a world in one file are called agent_1, agent_2 and so on: rename them"
                self._complaints.add(("agents",), text)
        for section, found in (("agents", groups), ("commanders", lines)):
            for key, group in found.items():
                self._claim(section, key, {*(member.name for member in group), key})
        plan = MachinePlan(file, {**groups, **lines}, self._complaints)
        if file.machines and not self._complaints:
            agents, commanders = plan.placed(agents, commanders)
        elif file.hosts is not None and not self._complaints:
            agents, commanders = in_hosts(agents, commanders, file.hosts)
        self._owners |= {m.process: m.name for m in (*agents, *commanders)}
        processes = tuple(self._processes())
        for machine in file.machines:
            self._claim("machines", machine, [machine])
        self._complaints.raise_any()
        machines = tuple(plan.machines((*agents, *commanders)))
        self._complaints.raise_any()
        own: dict[str, ReachLine] = {}
        own |= {m.name: file.agents[key] for key, group in groups.items() for m in group}
        own |= {m.name: file.commanders[key] for key, group in lines.items() for m in group}
        reach = {name: file.machines[m.name] for m in machines for name in m.processes}
        agents, commanders = with_reach(agents, commanders, own, file, reach)
        return SwarmDescription(
            name,
            self._path,
            tuple(_with_libraries(agents, groups)),
            world,
            tuple(commanders),
            f"/{file.namespace.strip('/')}" if file.namespace else "",
            processes,
            file.all_endpoints,
            machines,
        )

    def _tell(self, line: str, key: str, text: str, section: str = "commanders") -> None:
        self._complaints.add((section, line, key) if key else (section, line), text)

    def _tell_at(self, place: tuple[str, ...], line: Nodes, key: str, text: str) -> None:
        """Complain about a key, in the line or in the settings for all."""
        if text:
            where = place if key in line.model_fields_set else ()
            self._complaints.add((*where, key), text)

    def _check_folders(self, line: MemberSettings, *place: str) -> None:
        for key in sorted({"library", "start_from"} & line.model_fields_set):
            folder = getattr(line, key)
            library = self._start(folder) if key == "start_from" else self._path.parent / folder
            if folder and AGENT_MARK not in folder and not library.is_dir():
                text = (
                    f'`{key}:` there is no folder "{folder}"; make it, correct the path, which is '
                    "relative to this file, or leave it out"
                )
                self._complaints.add((*place, key), text)

    @property
    def _world_file(self) -> str:
        """Path of the world's file with its agents' vocabulary; empty without one."""
        world = self._file.world
        return world.kind if world is not None and world.kind.endswith(PYTHON_SUFFIX) else ""

    def _start(self, text: str) -> Path:
        """Return an initial library: a folder, or a named library, as for `up -l`."""
        library = self._path.parent / text
        return library if library.is_dir() else self._libraries.get(text, library)

    @cached_property
    def _libraries(self) -> dict[str, Path]:
        return known_libraries()

    def _in_file(self, text: str) -> str:
        """Return the path of a file with a world or vocabulary; other names stay unchanged."""
        return str((self._path.parent / text).resolve()) if text.endswith(PYTHON_SUFFIX) else text

    def _world(self, line: WorldLine) -> WorldDescription:
        kind, parameters = line.kind, line.parameters
        module = line.module or world_module(kind)
        if kind.endswith(PYTHON_SUFFIX):
            path = self._in_file(kind)
            kind, module = Path(path).stem, "hitab_world.simulation_main"
            count = sum(one.count or 1 for one in self._file.agents.values())
            parameters = {"file": path, "agents": count, **parameters}
        if not module_exists(module):
            text = (
                f'unknown world "{kind}": Python module {module} is not installed; install '
                "its package, or name the module with `module:`. Of a world in one file, give the "
                "file: my_world.py"
            )
            self._complaints.add(("world", "kind"), text)
        return WorldDescription(
            kind,
            module,
            line.pace,
            line.factor,
            line.teaching,
            line.seed,
            line.paused,
            parameters,
            line.node_parameters,
            {**self._file.remap, **line.remap},
        )

    # -- agents and commanders --------------------------------------------------------------

    def _agents(self) -> dict[str, list[AgentDescription]]:
        groups = {}
        for key, line in self._file.agents.items():
            self._check_folders(line, "agents", key)
            own = _under(self._file, line, MEMBERS)
            own = own.but(domain=self._in_file(own.domain or self._world_file))
            names = [f"{key}_{i + 1}" for i in range(line.count)] if line.count else [key]
            groups[key] = [
                AgentDescription(
                    domain=own.domain,
                    process=self._process(line, own.domain, key, name, index),
                    **self._common(own, key, name),
                )
                for index, name in enumerate(names)
            ]
            wrong_domain = self._words.wrong_domain(own.domain)
            self._tell_at(("agents", key), line, "domain", wrong_domain)
            wrong = self._words.wrong_behavior(groups[key][0])
            self._tell_at(("agents", key), line, "behavior", wrong)
        return groups

    def _process(self, line: AgentLine, domain: str, key: str, name: str, index: int) -> str:
        """Return the process of an agent; empty if the swarm's hosts run the agent.

        On several machines, these run all but robots, whose links are theirs alone.
        """
        if not line.host and line.per_process not in (None, 1):
            return f"{key}_host_{index // line.per_process + 1}"
        if self._file.machines:
            hosted = not self._words.has_robot(domain)
        else:
            hosted = self._file.hosts is not None
        return line.host or ("" if hosted and line.per_process is None else name)

    def _common(self, own: AgentLine | CommanderLine, key: str, name: str) -> dict[str, Any]:
        base = self._path.parent
        return {
            "name": name,
            "library": base / own.library.replace(AGENT_MARK, name) if own.library else None,
            "start_from": self._start(own.start_from) if own.start_from else None,
            "behavior": own.behavior,
            "seed": own.seed,
            "role": key if own.role is None else own.role,
            **_ros(own, name),
        }

    def _commander(self, key: str, name: str) -> CommanderDescription:
        line = self._file.commanders[key]
        # Of the settings for all agents, only the seed and those for all nodes apply here, too.
        own = _under(self._file, line, {*NODES, "seed"})
        hosted = self._file.hosts is not None or self._file.machines
        process = line.host or ("" if hosted else name)
        return CommanderDescription(domain="", process=process, **self._common(own, key, name))

    def _kinds(self) -> dict[str, CommanderKind]:
        """Return the kinds of commanders; kinds without orders get them from subordinates."""
        kinds = {}
        for name, line in self._file.kinds.items():
            before = len(self._complaints)
            try:
                if isinstance(line, KindRecord):
                    kinds[name] = kind_in(line, name, self._complaints, ("kinds", name))
                else:
                    kinds[name] = replace(read_kind(self._path.parent / line), name=name)
                if len(self._complaints) == before:
                    commander_domain(kinds[name])
            except HitabError as error:
                self._tell(name, "", str(error), "kinds")
        return kinds

    def _commanders(self, tree: CommanderTree) -> dict[str, list[CommanderDescription]]:
        for key, line in self._file.commanders.items():
            self._check_folders(line, "commanders", key)
            if line.kind not in self._file.kinds:
                known = has(self._file.kinds, line.kind)
                self._tell(key, "kind", f'there is no kind "{line.kind}" under `kinds:` {known}')
        found = tree.commanders()
        for key, group in found.items():
            for commander in group:
                if wrong := self._words.wrong_behavior(commander):
                    self._tell(key, "behavior", wrong)
        return found

    def _claim(self, section: str, key: str, names: Iterable[str]) -> None:
        """Claim names for a line; complain about names of another line."""
        for name in names:
            if name in self._owners:
                text = f'a second "{name}" (see `{self._owners[name]}`); rename one'
                self._tell(key, "", text, section)
            self._owners[name] = key

    # -- further processes ------------------------------------------------------------------

    def _processes(self) -> Iterator[Process]:
        for key, line in self._file.processes.items():
            self._claim("processes", key, [key])
            is_node = bool(line.module) or bool(ROS_WORDS & line.model_fields_set)
            ros = _ros(_under(self._file, line, NODES) if is_node else line)
            if AGENT_MARK in f"{ros}":
                text = (
                    f'"{AGENT_MARK}" stands for an agent: have it in the lines of `agents:` alone'
                )
                self._tell(key, "", text, "processes")
            yield Process(key, line.module, line.command, line.namespace, **ros, is_node=is_node)


def _with_libraries(
    agents: Sequence[AgentDescription], groups: Mapping[str, Sequence[AgentDescription]]
) -> list[AgentDescription]:
    """Name library folders: equal agents in a process share one."""
    keys = {agent.name: key for key, group in groups.items() for agent in group}
    inside: dict[str, set[str]] = {}
    for agent in agents:
        inside.setdefault(agent.process, set()).add(keys[agent.name])
    alone = {process for process, lines in inside.items() if len(lines) == 1}
    return [
        a if a.process in alone else replace(a, library_name=f"{a.process}_{keys[a.name]}")
        for a in agents
    ]
