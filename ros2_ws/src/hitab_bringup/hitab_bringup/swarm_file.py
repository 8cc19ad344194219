"""Reads swarm descriptions from their YAML files; see `hitab_bringup.swarm_description`."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from hitab_bringup.errors import DescriptionError
from hitab_bringup.names import WORLD
from hitab_bringup.swarm_description import (
    PACES,
    AgentDescription,
    SwarmDescription,
    WorldDescription,
)
from hitab_bringup.swarm_words import Words
from hitab_bringup.yaml_fields import Fields
from hitab_core.use import NAME
from hitab_core.yaml_places import Complaints, read_yaml

RESERVED = (WORLD, "distribution", "distribution_ack", "clock")
WORLDS = "hitab.worlds"
AGENT = "{agent}"
"""Stands for the agent's name in a path."""


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
    _check_name(top, name, "a swarm")
    world = _world(top) if "world" in top else None
    common = _Common.of(top, path.parent)
    agents = _agents(top, common, path.parent)
    top.done()
    complaints.raise_any()
    return SwarmDescription(name, path, tuple(agents), world)


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
    )
    fields.done()
    if kind and not _module_exists(module):
        fields.complain(
            f'there is no world "{kind}": Python module {module} is not installed; install its '
            "package, or name the module with `module:`",
            "kind",
        )
    return world


def world_module(kind: str) -> str:
    """Return the module that runs worlds of a kind.

    A package tells its own under the entry-point group ``hitab.worlds``; else it is
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
        if found.start_from != above.start_from and not (base / found.start_from).is_dir():
            fields.complain(
                f'`start_from:` there is no library folder "{found.start_from}"; correct the '
                "path, which begins at this file, or leave it out to begin with nothing",
                "start_from",
            )
        own = found.library != above.library and AGENT not in found.library
        if own and not (base / found.library).is_dir():
            fields.complain(
                f'`library:` there is no folder "{found.library}"; make it, or leave '
                "`library` out and each agent has its own in the run folder",
                "library",
            )
        return found

    def libraries(self, base: Path) -> list[Path]:
        """Return the folders that are known to hold trained behaviors already."""
        named = [text for text in (self.library, self.start_from) if text and AGENT not in text]
        return [base / text for text in named]


def _agents(top: Fields, common: _Common, base: Path) -> list[AgentDescription]:
    group = top.inner("agents")
    agents: list[AgentDescription] = []
    owners: dict[str, str] = {}
    if "agents" not in top or not group.names():
        top.complain("a swarm needs `agents:`, a line with a name each")
    words = Words(top)
    for key in group.names():
        fields = group.inner(key)
        _check_name(group, key, "an agent", key)
        own = _Common.of(fields, base, common)
        count = fields.integer("count", None, least=1)
        per_process = fields.integer("per_process", 1, least=1)
        host = fields.text("host", "")
        fields.done()
        words.check_domain(fields, own.domain)
        if own.behavior:
            words.check_behavior(fields, own.domain, own.behavior, own.libraries(base))
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
                    base / own.library.replace(AGENT, name) if own.library else None,
                    base / own.start_from if own.start_from else None,
                    own.behavior,
                    own.seed,
                    process,
                )
            )
    return agents


def _check_name(fields: Fields, name: Any, what: str, *inner: str) -> None:
    if not isinstance(name, str) or NAME.match(name) is None:
        fields.complain(f'"{name}" is not a name for {what}; use letters, digits and _', *inner)
    elif what == "an agent" and name in RESERVED:
        fields.complain(f'an agent cannot be called "{name}"; rename it', *inner)
