"""Vocabulary of a swarm: its domains and behaviors."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import entry_points
from pathlib import Path

from hitab_bringup.swarm_files.swarm_description import AgentDescription, CommanderDescription
from hitab_core import (
    ENTRY_POINT_GROUP,
    BehaviorLibrary,
    HitabError,
    Term,
    has,
    load_domain,
    unknown,
)
from hitab_core.library import BEHAVIOR_SUFFIX

Repertoire = Mapping[str, tuple[str, ...]]
"""Parameters of behaviors, by the behavior's name."""


class SwarmVocabulary:
    """The behaviors that members of a swarm can perform.

    Args:
        kept: names of behaviors in libraries of earlier runs, which a member may have.
    """

    def __init__(self, kept: frozenset[str] = frozenset()) -> None:
        self._kept = kept
        self._domains = [point.name for point in entry_points(group=ENTRY_POINT_GROUP)]
        self._repertoires: dict[tuple[str, ...], Repertoire] = {}
        self._robots: dict[str, bool] = {}  # a thousand agents have few domains

    def wrong_domain(self, name: str) -> str:
        """Return the fault of a domain's name; empty without one."""
        if not name:
            return f"`domain:` is missing {has(self._domains)}"
        if name in self._domains:
            return ""
        if ":" in name or name.endswith(".py"):  # not installed
            try:
                load_domain(name)
            except HitabError as error:
                return str(error)
            return ""
        return (
            f'no domain "{name}" is installed {has(self._domains, name)}; install the package '
            "that provides it beside HiTAB"
        )

    def has_robot(self, domain: str) -> bool:
        """Whether agents of a domain have links of their own, to robots, instead of a world's."""
        if domain not in self._robots:
            known = not self.wrong_domain(domain)
            self._robots[domain] = known and bool(load_domain(domain).link)
        return self._robots[domain]

    def wrong_behavior(self, member: AgentDescription) -> str:
        """Return why a member cannot perform its initial behavior; empty if it may.

        A library in the run folder is not known yet, so it is assumed to have missing behaviors;
        otherwise the agent itself reports them.
        """
        if not member.behavior:
            return ""
        try:
            name = Term.parse(member.behavior).name
        except HitabError as error:
            return str(error)
        names = {*self._own(member), *(name for f in _folders(member) for name in _in(f))}
        return "" if self.may_have(member, name) else unknown("behavior", name, names)

    def may_have(self, member: AgentDescription, behavior: str) -> bool:
        """Whether a member may have a behavior; a library in the run folder may hold more."""
        is_known = isinstance(member, CommanderDescription) or not self.wrong_domain(member.domain)
        folders = _folders(member)
        kept = behavior in self._kept or any(behavior in _in(folder) for folder in folders)
        return not is_known or not folders or kept or behavior in self._own(member)

    def repertoire(self, member: AgentDescription) -> Repertoire:
        """Return the behaviors that a member is known to have."""
        if isinstance(member, CommanderDescription):
            trained = {name: () for folder in _folders(member) for name in _in(folder)}
            return {**self._own(member), **trained}
        key = (member.domain, *map(str, _folders(member)))
        if key not in self._repertoires:
            self._repertoires[key] = self._own(member) | self._trained(member)
        return self._repertoires[key]

    def _own(self, member: AgentDescription) -> dict[str, tuple[str, ...]]:
        """Return the behaviors that need no training."""
        if isinstance(member, CommanderDescription):
            orders = member.kind.orders
            return {o.name: (o.parameter,) if o.parameter else () for o in orders}
        if self.wrong_domain(member.domain):
            return {}
        domain = load_domain(member.domain)
        known = {name: behavior.parameters for name, behavior in domain.behaviors.items()}
        return known | {name: automaton.parameters for name, automaton in domain.automata.items()}

    def _trained(self, member: AgentDescription) -> dict[str, tuple[str, ...]]:
        if self.wrong_domain(member.domain):
            return {}
        found: dict[str, tuple[str, ...]] = {}
        for folder in _folders(member):
            # The agent itself reports the faults of its library.
            trained = BehaviorLibrary(folder, load_domain(member.domain)).load(strict=False)
            found |= {name: automaton.parameters for name, automaton in trained.items()}
        return found


def _folders(member: AgentDescription) -> list[Path]:
    """Return the folders that already hold trained behaviors of a member."""
    named = (member.library, member.start_from)
    return [folder for folder in named if folder is not None and folder.is_dir()]


def _in(folder: Path) -> list[str]:
    """Return the names of the behaviors in a folder."""
    return [path.name.removesuffix(BEHAVIOR_SUFFIX) for path in folder.glob(f"*{BEHAVIOR_SUFFIX}")]
