"""The cast of a swarm that plays without ROS: each member's behavior and library."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hitab_bringup.libraries.library_choice import holds_behaviors, named_library
from hitab_bringup.libraries.opened_library import open_library
from hitab_bringup.processes.swarm_processes import library_of
from hitab_bringup.swarm_files.swarm_description import (
    AgentDescription,
    CommanderDescription,
    SwarmDescription,
)
from hitab_client.runs.run_folder import RunFolder
from hitab_commander import CommanderKind
from hitab_commander.commander_domain import commander_domain
from hitab_core import (
    BehaviorLibrary,
    HitabError,
    LibraryError,
    Repertoire,
    Term,
    has,
    load_domain,
)

UNTRAINED = "nothing"
_VERSION = re.compile(r"(\w+)@(\d+)")


@dataclass(frozen=True)
class CastMember:
    """A member of a cast: an agent or commander with its behavior and library.

    Attributes:
        repertoire: behaviors of the member.
        behavior: behavior from the beginning of each episode; None for the commander's order.
        opened: the member's library; None without learned behaviors.
        versions: versions of behaviors, except present ones.
    """

    repertoire: Repertoire
    behavior: Term | None
    opened: BehaviorLibrary | None = None
    versions: Mapping[str, int] = field(default_factory=dict)


def part_of(
    library: Path | None,
    behavior: str,
    *,
    domain: str = "",
    kind: CommanderKind | None = None,
    versions: Mapping[str, int] | None = None,
) -> CastMember:
    """Return the cast member of an agent with a library.

    Args:
        library: folder of the agent's library.
        behavior: a behavior of the library or the domain; empty for the commander's order.
        domain: domain of an agent without a library.
        kind: kind of a commander; None for an agent.
        versions: versions of behaviors in the library, instead of the present ones.

    Raises:
        LibraryError: if the library cannot be used, or has no such behavior or version.
    """
    term = Term.parse(behavior) if behavior else None
    if library is None:
        repertoire = Repertoire(load_domain(domain))
        if term is not None:
            repertoire.check_performable(term)
        return CastMember(repertoire, term)
    opened = (
        open_library(library) if kind is None else BehaviorLibrary(library, commander_domain(kind))
    )
    automata = opened.load()
    versions = versions or {}
    for name, number in versions.items():
        automata[name] = opened.on_disk.version(name, number).automaton
    repertoire = Repertoire(opened.domain, automata)
    if term is not None:
        if term.name not in repertoire:
            behaviors = [*automata, *opened.domain.automata]
            raise LibraryError(
                f'{library}: has no behavior "{term.name}" {has(behaviors, term.name)}'
            )
        repertoire.check_performable(term)
    return CastMember(repertoire, term, opened, versions)


class Cast:
    """The cast of a swarm with a world: each member's behavior and library.

    Args:
        swarm: the description.
        libraries: see `choose_libraries`.
        behaviors: see `choose_behaviors`.
    """

    def __init__(
        self,
        swarm: SwarmDescription,
        libraries: Sequence[str] | None = None,
        behaviors: Sequence[str] | None = None,
    ) -> None:
        self._agents = {agent.name: agent for agent in swarm.agents}
        self._commanders = {commander.name: commander for commander in swarm.commanders}
        self._members = {**self._agents, **self._commanders}
        self._folder = RunFolder.of_swarm(swarm.name).path
        self._behaviors = {agent.name: agent.behavior for agent in swarm.members}
        self._libraries = {agent.name: self._own(agent) for agent in swarm.members}
        self._versions: dict[str, dict[str, int]] = {}
        self.choose_libraries(libraries or ())
        self.choose_behaviors(behaviors or ())

    def _own(self, agent: AgentDescription) -> Path | None:
        """Return an agent's present or initial library; None without trained behaviors."""
        for folder in (library_of(agent, self._folder), agent.start_from):
            if folder is not None and holds_behaviors(folder):
                return folder
        return None

    def choose_libraries(self, texts: Sequence[str]) -> None:
        """Give agents libraries, or versions of behaviors: ``[AGENT=]LIBRARY`` or ``NAME@1``.

        Raises:
            LibraryError: if there is no such library.
        """
        for agents, text in map(self._whose, texts):
            if version := _VERSION.fullmatch(text):
                behavior, number = version[1], int(version[2])
                # Agents in other roles have learned other behaviors, or have other versions.
                having = [
                    name
                    for name in agents
                    if (library := self._libraries[name])
                    and number in open_library(library).on_disk.versions(behavior)
                ]
                for name in having or agents:  # else an error for the first
                    self._versions.setdefault(name, {})[behavior] = number
            else:
                self._libraries |= dict.fromkeys(agents, named_library(text))

    def choose_behaviors(self, texts: Sequence[str]) -> None:
        """Give agents behaviors: ``[AGENT=]BEHAVIOR``, or ``nothing``.

        If all agents are given a behavior, their commanders give no orders.
        """
        for agents, text in map(self._whose, texts):
            if agents == [*self._agents]:
                self._behaviors |= dict.fromkeys(self._commanders, "")
            self._behaviors |= dict.fromkeys(agents, "" if text == UNTRAINED else text)

    def _whose(self, text: str) -> tuple[list[str], str]:
        """Return the agents that a choice is for, and the choice; without a name, all agents."""
        name, equals, rest = text.partition("=")
        if equals and name in self._members:
            return [name], rest
        if equals and not Path(text).exists():
            raise HitabError(f'no agent "{name}" {has(self._members, name)}')
        return [*self._agents], text

    def parts(self) -> dict[str, CastMember]:
        """Return the cast of agents and commanders, without members that do nothing.

        Raises:
            HitabError: if no member performs anything, or a member's behavior is missing.
        """
        parts = {}
        ordered = self._ordered()
        for name, behavior in self._behaviors.items():
            member, library = self._members[name], self._libraries[name]
            if not behavior and name not in ordered:
                continue
            kind = member.kind if isinstance(member, CommanderDescription) else None
            if kind is not None and library is None:
                raise HitabError(
                    f"{name} has learned no behavior to perform; give it a library with "
                    f"-l {name}=LIBRARY, or have it order nothing with -b {name}=nothing"
                )
            parts[name] = part_of(
                library,
                behavior,
                domain=member.domain,
                kind=kind,
                versions=self._versions.get(name),
            )
        if not parts:
            raise HitabError("no agent performs anything; name a behavior with -b NAME")
        return parts

    def _ordered(self) -> set[str]:
        """Return the members below a commander that performs something, on all levels."""
        found: set[str] = set()
        superiors = [name for name in self._commanders if self._behaviors[name]]
        while superiors:
            below = {*self._commanders[superiors.pop()].subordinates} - found
            found |= below
            superiors += below & self._commanders.keys()
        return found
