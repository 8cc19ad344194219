"""Command hierarchy of a swarm: commanders, their subordinates, orders and processes.

A name in `commands:` refers to an agent or a commander, or to all members of a line with several.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from hitab_bringup.swarm_files.swarm_description import AgentDescription, CommanderDescription
from hitab_bringup.swarm_files.swarm_lines import CommanderLine
from hitab_bringup.swarm_files.swarm_vocabulary import SwarmVocabulary
from hitab_commander import CommanderKind, OrderMap
from hitab_core import Term, has, unknown
from hitab_core.orders import ALL_OTHERS

Member = TypeVar("Member", bound=AgentDescription)
Complain = Callable[[str, str, str], None]
"""Called with the name of a line, a key of the line or "", and the fault."""


class CommanderTree:
    """Builds the commanders, and reports every fault of the tree.

    Args:
        groups: agents, by the key of their line.
        lines: lines of commanders, by key.
        kinds: kinds of commanders, by name.
        make: returns a commander of a line, given the line's key and the commander's name.
        words: vocabulary of the behaviors that members can be ordered to perform.
        complain: called with each fault of a line.

    Attributes:
        superiors: commanders of the members that have one, by the member's name.
    """

    def __init__(
        self,
        groups: Mapping[str, Sequence[AgentDescription]],
        lines: Mapping[str, CommanderLine],
        kinds: Mapping[str, CommanderKind],
        make: Callable[[str, str], CommanderDescription],
        words: SwarmVocabulary,
        complain: Complain,
    ) -> None:
        self.superiors: dict[str, str] = {}
        self._groups = {a.name: [a] for group in groups.values() for a in group} | {
            key: list(group) for key, group in groups.items()
        }
        self._lines, self._kinds, self._make = lines, kinds, make
        self._words, self._complain = words, complain
        self._open: list[str] = []

    def commanders(self) -> dict[str, list[CommanderDescription]]:
        """Return the commanders by the key of their line, with `asks_position` where needed."""
        made = {
            key: [m for m in self._members(key) or () if isinstance(m, CommanderDescription)]
            for key in self._lines
        }
        by_name = {member.name: member for group in made.values() for member in group}

        def asks(name: str) -> bool:
            above = self.superiors.get(name, "")
            return name in by_name and (by_name[name].kind.asks_position or asks(above))

        return {
            key: [replace(m, asks_position=asks(m.name)) for m in self.with_superiors(group)]
            for key, group in made.items()
        }

    def with_superiors(self, members: Sequence[Member]) -> list[Member]:
        """Return members with their commanders filled in."""
        return [replace(m, superior=self.superiors.get(m.name, "")) for m in members]

    def _members(self, key: str) -> list[AgentDescription] | None:
        """Return the members that a name refers to, creating commanders first; None if unknown."""
        if key in self._groups or key not in self._lines:
            return self._groups.get(key)
        if key in self._open:
            circle = " -> ".join([*self._open[self._open.index(key) :], key])
            text = f"commanders in a circle: {circle}; remove one of these from `commands:`"
            self._complain(key, "commands", text)
            return []
        self._open.append(key)
        made = self._made(key, self._lines[key])
        self._open.pop()
        # A commander that is part of a circle has been added in the meantime.
        self._groups[key] = list(made)
        for member in made:
            self._groups.setdefault(member.name, [member])
        return self._groups[key]

    def _made(self, key: str, line: CommanderLine) -> list[CommanderDescription]:
        found: dict[str, list[AgentDescription]] = {}
        for name in line.commands:
            members = self._members(name)
            if members is None:
                known = {*self._groups, *self._lines}
                text = f'`commands:` there is no agent or commander "{name}" {has(known, name)}'
                self._complain(key, "commands", text)
            else:
                found[name] = members
        if not isinstance(line.commands, dict):
            together = [member for members in found.values() for member in members]
            return [self._commander(key, line, key, together)] if together else []
        counts = line.commands
        needed = {n: -(-len(members) // counts[n]) for n, members in found.items() if members}
        if len(set(needed.values())) > 1:
            given = ", ".join(f"{count} of {name}" for name, count in needed.items())
            text = (
                f"`commands:` these counts give different numbers of commanders ({given}); change "
                "the counts, or the sizes of the groups"
            )
            self._complain(key, "commands", text)
        return [
            self._commander(
                key,
                line,
                f"{key}_{i + 1}",
                [m for n, all_ in found.items() for m in all_[i * counts[n] :][: counts[n]]],
            )
            for i in range(max(needed.values(), default=0))
        ]

    def _commander(
        self, key: str, line: CommanderLine, name: str, share: Sequence[AgentDescription]
    ) -> CommanderDescription:
        for member in share:
            other = self.superiors.setdefault(member.name, name)
            if other != name:
                text = (
                    f'"{member.name}" has two commanders, "{other}" and "{name}"; '
                    "remove it from one"
                )
                self._complain(key, "commands", text)
        kind = self._kinds.get(line.kind)
        if kind is not None and not kind.orders:
            shared = self._shared_behaviors(key, share)
            orders = tuple(OrderMap(name, {ALL_OTHERS: name}) for name in shared)
            described = {**kind.described, "orders": {name: name for name in shared}}
            kind = replace(kind, orders=orders, described=described)
        kind = kind or CommanderKind(line.kind, ())
        for order in kind.orders:
            for member in share:
                for wrong in self._wrong(order, member):
                    self._complain(key, "", f'the order "{order.name}" {wrong}')
        subordinates = {member.name: member.role for member in share}
        made = self._make(key, name)
        return replace(
            made, kind=kind, domain=kind.name, library_name=kind.name, subordinates=subordinates
        )

    def _shared_behaviors(self, key: str, share: Sequence[AgentDescription]) -> list[str]:
        """Return the behaviors without parameters that all subordinates have."""
        known = (self._words.repertoire(member).items() for member in share)
        names = [{name for name, parameters in one if not parameters} for one in known]
        shared = set.intersection(*names)
        if not shared:
            text = "has no orders, and its subordinates share no behavior; give its kind `orders:`"
            self._complain(key, "", text)
        return sorted(shared)

    def _wrong(self, order: OrderMap, member: AgentDescription) -> Iterator[str]:
        """Yield the faults of an order for a member, in equal words for similar members."""
        if not order.covers(member.role):
            yield f'has no behavior for role "{member.role}"; add it, or `others:`'
            return
        for receiver in {member.role, order.parameter or ALL_OTHERS}:
            if not (behavior := order.for_role(receiver)):
                continue
            term, known = Term.parse(behavior), self._words.repertoire(member)
            if term.name in known and len(known[term.name]) != len(term.arguments):
                wanted = ", ".join(known[term.name]) or "none"
                count = len(known[term.name])
                yield (
                    f'gives role "{member.role}" "{behavior}", which takes {count} target(s) '
                    f"({wanted})"
                )
            elif term.name not in known and not self._words.may_have(member, term.name):
                yield f'gives role "{member.role}" the {unknown("behavior", term.name, known)}'


def in_hosts(
    agents: Sequence[AgentDescription],
    commanders: Sequence[CommanderDescription],
    hosts: int,
    prefix: str = "",
) -> tuple[list[AgentDescription], list[CommanderDescription]]:
    """Distribute members without a process of their own to some hosts, keeping groups together.

    Agents are distributed evenly in the order of the tree, so that most commanders share a process
    with all their subordinates. A commander runs where its first subordinate of these members
    does, or else in the first host.

    Args:
        agents, commanders: the members.
        hosts: number of hosts.
        prefix: beginning of the hosts' names.
    """
    by_name: dict[str, AgentDescription] = {m.name: m for m in (*agents, *commanders)}

    def below(commander: CommanderDescription) -> list[AgentDescription]:
        return [by_name[name] for name in commander.subordinates if name in by_name]

    def leaves(member: AgentDescription) -> Iterator[str]:
        if isinstance(member, CommanderDescription):
            for subordinate in below(member):
                yield from leaves(subordinate)
        elif not member.process:
            yield member.name

    roots = [member for member in (*commanders, *agents) if member.superior not in by_name]
    ordered = [name for root in roots for name in leaves(root)]
    host_of = {
        name: f"{prefix}host_{index * hosts // len(ordered) + 1}"
        for index, name in enumerate(ordered)
    }

    def place(member: AgentDescription) -> str:
        if member.process or not isinstance(member, CommanderDescription):
            return member.process or host_of[member.name]
        subordinates = below(member)
        return place(subordinates[0]) if subordinates else f"{prefix}host_1"

    def placed(member: Member) -> Member:
        return replace(member, process=place(member))

    return [placed(agent) for agent in agents], [placed(c) for c in commanders]
