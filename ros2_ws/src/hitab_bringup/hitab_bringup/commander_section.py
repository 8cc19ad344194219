"""Reads `kinds:` and `commanders:` of a swarm description: the command hierarchy.

    kinds:
      Squad: {orders: ...}              # see hitab_commander.kind_reader
      Company: company.yaml             # or a file that describes the kind
    commanders:
      captain: {kind: Company, commands: [scout_1, scout_2, corporal]}   # one, over all of these
      corporal: {kind: Squad, commands: {scout: 1, carrier: 4}}          # as many as it takes

A name refers to an agent or a commander, or to all members of a line with several.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from hitab_bringup.swarm_description import AgentDescription, CommanderDescription
from hitab_commander import CommanderKind, OrderMap, parse_kind, read_kind
from hitab_commander.commander_domain import commander_domain
from hitab_core import HitabError, Use, has, unknown
from hitab_core.commanding import OTHERS
from hitab_core.library import Fields


class Repertoires(Protocol):
    """The behaviors that members can be ordered to perform."""

    def repertoire(self, member: AgentDescription) -> Mapping[str, tuple[str, ...]]:
        """Return the behaviors that a member is known to have, with their parameters."""

    def may_have(self, member: AgentDescription, behavior: str) -> bool:
        """Whether it may have this behavior although it is not known to."""


def read_kinds(top: Fields, base: Path) -> dict[str, CommanderKind]:
    """Read the kinds of commanders; kinds without orders get them from their subordinates."""
    section = top.inner("kinds")
    kinds: dict[str, CommanderKind] = {}
    for name in section.names():
        value = section.raw(name)
        before = len(section.complaints)
        if isinstance(value, str):
            try:
                kind = replace(read_kind(base / value), name=name)
            except HitabError as error:
                section.complain(str(error), name)
                continue
        else:
            kind = parse_kind(name, section.inner(name))
        if len(section.complaints) == before:
            try:
                commander_domain(kind)
            except HitabError as error:
                section.complain(str(error), name)
        kinds[name] = kind
    return kinds


@dataclass
class Line:
    """One line of `commanders:`.

    Attributes:
        fields: the fields of the line.
        make: makes one of its commanders, given its name.
        kind: of its commanders; None: unknown.
        counts: number of members of each group per commander; None: one commander for all.
        groups: the names of the groups.
    """

    fields: Fields
    make: Callable[[str], CommanderDescription]
    kind: CommanderKind | None
    counts: Mapping[str, int] | None
    groups: Sequence[str]


class CommanderSection:
    """Builds the command tree and complains about anything that is not a tree.

    Args:
        groups: the agents by the key of their line; a single agent by its name.
        repertoires: the behaviors that members can be ordered to perform.
    """

    def __init__(
        self, groups: Mapping[str, Sequence[AgentDescription]], repertoires: Repertoires
    ) -> None:
        self._groups: dict[str, list[AgentDescription]] = {k: list(v) for k, v in groups.items()}
        for members in groups.values():
            for member in members:
                self._groups.setdefault(member.name, [member])
        self._repertoires = repertoires
        self._lines: dict[str, Line] = {}
        self._open: list[str] = []
        self._superiors: dict[str, str] = {}

    def read_commands(self, fields: Fields) -> tuple[Mapping[str, int] | None, Sequence[str]]:
        """Read the field ``commands`` of a line: counts by group, or names."""
        value = fields.raw("commands")
        if isinstance(value, dict):
            inner = fields.inner("commands")
            counts = {name: inner.integer(name, 1, least=1) for name in inner.names()}
            return counts, list(counts)
        names = fields.texts("commands", ()) if value is not None else ()
        if value is not None and not names:
            fields.complain("`commands:` is empty; name its subordinates", "commands")
        return None, names

    def resolve(
        self, lines: Mapping[str, Line]
    ) -> tuple[list[CommanderDescription], dict[str, tuple[str, str]]]:
        """Return all commanders, and each subordinate's superior and role."""
        self._lines = dict(lines)
        for key in lines:
            self._members(key)
        commanders = [
            member
            for key in lines
            for member in self._groups.get(key, ())
            if isinstance(member, CommanderDescription)
        ]
        roles = {name: role for member in commanders for name, role in member.subordinates.items()}
        return commanders, {name: (s, roles[name]) for name, s in self._superiors.items()}

    def _members(self, key: str) -> list[AgentDescription] | None:
        """Return the members that a name refers to, making commanders first; None: unknown."""
        if key in self._groups:
            return self._groups[key]
        line = self._lines.get(key)
        if line is None:
            return None
        if key in self._open:
            circle = " -> ".join([*self._open[self._open.index(key) :], key])
            line.fields.complain(
                f"commanders in a circle: {circle}; remove one of these from `commands:`",
                "commands",
            )
            return []
        self._open.append(key)
        made = self._made(key, line)
        self._open.pop()
        # A commander that is part of a circle has been added in the meantime.
        self._groups[key] = list(made)
        for member in made:
            self._groups.setdefault(member.name, [member])
        return self._groups[key]

    def _made(self, key: str, line: Line) -> list[CommanderDescription]:
        found: dict[str, list[AgentDescription]] = {}
        for name in line.groups:
            members = self._members(name)
            if members is None:
                known = [*self._groups, *self._lines]
                line.fields.complain(
                    f'`commands:` there is no agent or commander "{name}" {has(set(known), name)}',
                    "commands",
                )
            else:
                found[name] = members
        shares = self._shares(line, found)
        return [
            self._commander(line, key if line.counts is None else f"{key}_{i + 1}", share)
            for i, share in enumerate(shares)
        ]

    def _shares(
        self, line: Line, found: Mapping[str, list[AgentDescription]]
    ) -> list[list[AgentDescription]]:
        """Return the subordinates of each commander of a line."""
        if line.counts is None:
            together = [member for members in found.values() for member in members]
            return [together] if together else []
        needed = {
            name: -(-len(members) // line.counts[name])
            for name, members in found.items()
            if members
        }
        if len(set(needed.values())) > 1:
            told = ", ".join(f"{count} of {name}" for name, count in needed.items())
            line.fields.complain(
                f"`commands:` these counts give different numbers of commanders ({told}); change "
                "the counts, or the sizes of the groups",
                "commands",
            )
        return [
            [
                member
                for name, members in found.items()
                for member in members[index * line.counts[name] : (index + 1) * line.counts[name]]
            ]
            for index in range(max(needed.values(), default=0))
        ]

    def _commander(
        self, line: Line, name: str, share: Sequence[AgentDescription]
    ) -> CommanderDescription:
        for member in share:
            other = self._superiors.setdefault(member.name, name)
            if other != name:
                line.fields.complain(
                    f'"{member.name}" has two commanders, "{other}" and "{name}"; '
                    "remove it from one",
                    "commands",
                )
        kind = line.kind or CommanderKind("", ())
        if line.kind is not None and not kind.orders:
            kind = replace(kind, orders=self._shared_orders(line, share))
        self._check_orders(line, kind, share)
        made = line.make(name)
        return replace(
            made, kind=kind, subordinates={member.name: member.role for member in share}
        )

    # -- orders -----------------------------------------------------------------------------

    def _shared_orders(
        self, line: Line, share: Sequence[AgentDescription]
    ) -> tuple[OrderMap, ...]:
        """Return an order for each behavior without parameters that all subordinates share."""
        shared: set[str] | None = None
        for member in share:
            known = self._repertoires.repertoire(member)
            names = {name for name, parameters in known.items() if not parameters}
            shared = names if shared is None else shared & names
        if not shared and share:
            line.fields.complain(
                "has no orders, and its subordinates share no behavior; give its kind `orders:`"
            )
        return tuple(OrderMap(name, {OTHERS: name}) for name in sorted(shared or ()))

    def _check_orders(
        self, line: Line, kind: CommanderKind, share: Sequence[AgentDescription]
    ) -> None:
        seen: set[tuple[Any, ...]] = set()
        for member in share:
            for order in kind.orders:
                if not order.covers(member.role):
                    what = f'the order "{order.name}" has no behavior for role "{member.role}"'
                    self._once(line, seen, f"{what}; add it, or `others:`")
                    continue
                for receiver in (member.role, order.parameter):
                    behavior = order.for_role(receiver) if receiver else order.for_role(OTHERS)
                    self._check_behavior(line, seen, order, member, behavior)

    def _check_behavior(
        self,
        line: Line,
        seen: set[tuple[Any, ...]],
        order: OrderMap,
        member: AgentDescription,
        behavior: str | None,
    ) -> None:
        if not behavior:
            return
        use, known = Use.parse(behavior), self._repertoires.repertoire(member)
        if use.name not in known:
            if self._repertoires.may_have(member, use.name):
                return
            self._once(
                line,
                seen,
                f'the order "{order.name}" gives "{member.name}" the '
                f"{unknown('behavior', use.name, known)}",
                order.name,
                use.name,
            )
        elif len(known[use.name]) != len(use.arguments):
            wanted = ", ".join(known[use.name]) or "none"
            self._once(
                line,
                seen,
                f'the order "{order.name}" gives "{member.name}" "{behavior}", which takes '
                f"{len(known[use.name])} target(s) ({wanted})",
                order.name,
                use.name,
            )

    @staticmethod
    def _once(line: Line, seen: set[tuple[Any, ...]], text: str, *about: str) -> None:
        """Complain only once about a fault that similar members share."""
        key = about or (text,)
        if key not in seen:
            seen.add(key)
            line.fields.complain(text)
