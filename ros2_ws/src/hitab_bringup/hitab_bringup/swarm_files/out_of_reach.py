"""What the members of a swarm do out of reach: the lines of a swarm file, merged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from typing import Any, TypeVar

from hitab_bringup.swarm_files.swarm_description import AgentDescription, CommanderDescription
from hitab_bringup.swarm_files.swarm_lines import ReachLine

Member = TypeVar("Member", bound=AgentDescription)


def with_reach(
    agents: Sequence[AgentDescription],
    commanders: Sequence[CommanderDescription],
    lines: Mapping[str, ReachLine],
    swarm: ReachLine,
    machines: Mapping[str, ReachLine],
) -> tuple[list[AgentDescription], list[CommanderDescription]]:
    """Return the members with parameters for what they do out of reach.

    A member's own line counts first, then those of its commander and of all above, that of its
    machine, and that of the swarm; each key for itself.

    The parameter ``superiors`` names who must be in reach of a member that halts, besides its own
    commander: the commanders above, as far as each of them halts without the next.

    Args:
        agents: the agents.
        commanders: the commanders.
        lines: the members' own lines, by name.
        swarm: the line of the swarm.
        machines: the lines of machines, by the name of each process that they run.
    """
    members = (*agents, *commanders)
    superior = {member.name: member.superior for member in members}

    def above(name: str) -> Iterator[str]:
        while name := superior[name]:
            yield name

    def merged(member: AgentDescription) -> dict[str, Any]:
        of_machine = [machines[member.process]] if member.process in machines else []
        of_superiors = [lines[name] for name in above(member.name)]
        settings: dict[str, Any] = {}
        for line in (swarm, *of_machine, *reversed(of_superiors), lines[member.name]):
            given = ReachLine.model_fields.keys() & line.model_fields_set
            settings |= {key: getattr(line, key) for key in given}
        return settings

    parameters = {member.name: merged(member) for member in members}
    halting = {name for name, its in parameters.items() if its.get("when_out_of_reach") == "halt"}
    for name in halting:
        found = [*above(name)]
        until = 1 + len([*takewhile(halting.__contains__, found)])
        if found[1:until]:
            parameters[name]["superiors"] = tuple(found[1:until])

    def applied(member: Member) -> Member:
        return replace(member, parameters={**member.parameters, **parameters[member.name]})

    return [applied(agent) for agent in agents], [applied(one) for one in commanders]
