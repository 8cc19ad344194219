"""Derives superiors, roles and processes from the command hierarchy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from hitab_bringup.swarm_description import AgentDescription, CommanderDescription

Member = TypeVar("Member", bound=AgentDescription)


def with_superiors(
    members: Sequence[Member], superiors: Mapping[str, tuple[str, str]]
) -> list[Member]:
    """Return the members with their commander and role filled in."""
    return [
        replace(member, superior=superiors[member.name][0], role=superiors[member.name][1])
        if member.name in superiors
        else member
        for member in members
    ]


def with_positions_asked(
    commanders: Sequence[CommanderDescription],
) -> list[CommanderDescription]:
    """Return the commanders; each asks for positions if its kind or a superior does."""
    by_name = {commander.name: commander for commander in commanders}

    def asks(name: str) -> bool:
        commander = by_name.get(name)
        return commander is not None and (commander.kind.asks_position or asks(commander.superior))

    return [replace(c, asks_position=asks(c.name)) for c in commanders]


def in_hosts(
    agents: Sequence[AgentDescription],
    commanders: Sequence[CommanderDescription],
    hosts: int,
) -> tuple[list[AgentDescription], list[CommanderDescription]]:
    """Distribute all members without their own process to this many hosts, groups together.

    Agents are distributed evenly in the order of the tree, so that most commanders share a process
    with all their subordinates. A commander runs where its first subordinate does.
    """
    by_name: dict[str, AgentDescription] = {m.name: m for m in (*agents, *commanders)}

    def leaves(member: AgentDescription) -> Iterator[str]:
        if isinstance(member, CommanderDescription):
            for name in member.subordinates:
                yield from leaves(by_name[name])
        elif not member.process:
            yield member.name

    roots = [member for member in (*commanders, *agents) if not member.superior]
    ordered = [name for root in roots for name in leaves(root)]
    host_of = {
        name: f"host_{index * hosts // len(ordered) + 1}" for index, name in enumerate(ordered)
    }

    def place(member: AgentDescription) -> str:
        if member.process or not isinstance(member, CommanderDescription):
            return member.process or host_of[member.name]
        return place(by_name[next(iter(member.subordinates))])

    def placed(member: Member) -> Member:
        return member if member.process else replace(member, process=place(member))

    return [placed(agent) for agent in agents], [placed(c) for c in commanders]
