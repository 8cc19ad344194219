"""Checks that the domains and behaviors in a swarm description exist."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import entry_points
from pathlib import Path

from hitab_bringup.swarm_description import AgentDescription, CommanderDescription
from hitab_core import (
    ENTRY_POINT_GROUP,
    BehaviorLibrary,
    HitabError,
    Use,
    has,
    load_domain,
    unknown,
)
from hitab_core.library import SUFFIX, Fields


class Words:
    """Checks words; complains only once about a setting for all agents.

    Args:
        top: the top-level fields of the description.
        kept: names of behaviors in the libraries of earlier runs, which an agent may have.
    """

    def __init__(self, top: Fields, kept: frozenset[str] = frozenset()) -> None:
        self._top = top
        self._kept = kept
        self._domains = [point.name for point in entry_points(group=ENTRY_POINT_GROUP)]
        self._said: set[str] = set()
        self._repertoires: dict[tuple[str, ...], Mapping[str, tuple[str, ...]]] = {}

    def _complain(self, fields: Fields, key: str, text: str) -> None:
        """Complain at the word: in the agent's line, or above."""
        if key in fields:
            fields.complain(text, key)
        elif text not in self._said:
            self._said.add(text)
            self._top.complain(text, *([key] if key in self._top else []))

    def check_domain(self, fields: Fields, name: str) -> None:
        """Complain if there is no such domain."""
        if not name:
            self._complain(fields, "domain", f"`domain:` is missing {has(self._domains)}")
        elif ":" in name:  # not installed: "module:ATTRIBUTE"
            try:
                load_domain(name)
            except HitabError as error:
                self._complain(fields, "domain", str(error))
        elif name not in self._domains:
            self._complain(
                fields,
                "domain",
                f'no domain "{name}" is installed {has(self._domains, name)}; install the package '
                "that provides it, as docs/your-own-robot.md shows",
            )

    def check_without(self, fields: Fields, domain: str, names: Sequence[str]) -> None:
        """Complain if something cannot be taken out of a domain."""
        if not names or domain not in self._domains:
            return
        try:
            load_domain(domain).without(names)
        except HitabError as error:
            self._complain(fields, "without", f"`without:` {error}")

    def check_behavior(
        self, fields: Fields, domain: str, behavior: str, libraries: Sequence[Path]
    ) -> None:
        """Complain if an agent cannot perform a behavior.

        A library in the run folder is not known yet, so it is assumed to have what is missing; if
        not, the agent itself complains.
        """
        try:
            use = Use.parse(behavior)
            if domain not in self._domains or not libraries:
                return
            known = load_domain(domain)
        except HitabError as error:
            self._complain(fields, "behavior", str(error))
            return
        names = {*known.behaviors, *known.automata}.union(*map(_in, libraries))
        if use.name not in names | self._kept:
            self._complain(fields, "behavior", unknown("behavior", use.name, names))

    def check_commander(self, fields: Fields, commander: CommanderDescription) -> None:
        """Complain if a commander cannot perform its initial behavior."""
        if not commander.behavior:
            return
        try:
            use = Use.parse(commander.behavior)
        except HitabError as error:
            fields.complain(str(error), "behavior")
            return
        known = self.repertoire(commander)
        if not (use.name in known or self.may_have(commander, use.name)):
            fields.complain(unknown("behavior", use.name, known), "behavior")

    def repertoire(self, member: AgentDescription) -> Mapping[str, tuple[str, ...]]:
        """Return the known behaviors of a member, with their parameters."""
        if isinstance(member, CommanderDescription):
            known = {
                order.name: (order.parameter,) if order.parameter else ()
                for order in member.kind.orders
            }
            return {**known, **{name: () for folder in _folders(member) for name in _in(folder)}}
        key = (member.domain, *(str(folder) for folder in _folders(member)))
        if key not in self._repertoires:
            self._repertoires[key] = self._read_repertoire(member)
        return self._repertoires[key]

    def may_have(self, member: AgentDescription, behavior: str) -> bool:
        """Whether a member may have a behavior that is not in its `repertoire`.

        A library in the run folder may hold more than what it was filled from.
        """
        if not isinstance(member, CommanderDescription) and member.domain not in self._domains:
            return True
        return not _folders(member) or behavior in self._kept

    def _read_repertoire(self, member: AgentDescription) -> Mapping[str, tuple[str, ...]]:
        if member.domain not in self._domains:
            return {}
        domain = load_domain(member.domain)
        known = {name: behavior.parameters for name, behavior in domain.behaviors.items()}
        known |= {name: automaton.parameters for name, automaton in domain.automata.items()}
        for folder in _folders(member):
            # The agent itself reports what is wrong with its library.
            trained = BehaviorLibrary(folder, domain).load(strict=False)
            known |= {name: automaton.parameters for name, automaton in trained.items()}
        return known


def _folders(member: AgentDescription) -> list[Path]:
    """Return the folders that already hold trained behaviors of a member."""
    named = (member.library, member.start_from)
    return [folder for folder in named if folder is not None and folder.is_dir()]


def _in(folder: Path) -> list[str]:
    """Return the names of the behaviors in a folder."""
    return [path.name.removesuffix(SUFFIX) for path in folder.glob(f"*{SUFFIX}")]
