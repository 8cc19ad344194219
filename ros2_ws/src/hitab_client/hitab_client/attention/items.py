"""Items that deserve a look, the most important first."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from typing import Any

from hitab_core import Fix, Remedy, natural, quantity


class Kind(Enum):
    """Kinds of concerns, the most urgent first."""

    SILENT = "silent"  # a machine, a host or an agent that does not answer
    FAULT = "fault"  # an agent with faults, such as one that cannot act
    DISOBEYS = "disobeys"  # a member that does not perform its commander's order
    STUCK = "stuck"  # an agent that gets nowhere although its mates do
    UNARMED = "unarmed"  # a robot that may act again once a person arms it
    UNSURE = "unsure"  # decisions that are far from all examples
    LIBRARY = "library"  # behaviors that differ from those of the mates


URGENCY: Mapping[Kind, int] = {kind: -order for order, kind in enumerate(Kind)}


@dataclass(frozen=True)
class Concern:
    """Something about one agent that deserves a look.

    Attributes:
        name: name of the agent, host or machine.
        what: what is the case, after "is" or a verb, in words that alike cases share.
        why: what shows it, of this agent.
        remedies: ways out.
        agents: number of agents concerned.
        teaches: the behavior that one of several alike agents may be taught for all; empty if
            there is none.
    """

    kind: Kind
    name: str
    what: str
    why: str = ""
    remedies: tuple[Remedy, ...] = ()
    agents: int = 1
    teaches: str = ""


@dataclass(frozen=True)
class Item:
    """Alike concerns of one group.

    Attributes:
        names: the agents, hosts or machines concerned, in natural order.
        group: the commander, host or machine that they belong to; empty if none.
        why: what shows it, of the first of them.
        since: time at which the first of them was found, on the monotonic clock, s.
        remedies: ways out, of all of them.
        agents: number of agents concerned.
        teaches: as in `Concern`.
    """

    kind: Kind
    names: tuple[str, ...]
    group: str
    what: str
    why: str = field(default="", compare=False)
    since: float = field(default=0.0, compare=False)
    remedies: tuple[Remedy, ...] = field(default=(), compare=False)
    agents: int = 1
    teaches: str = ""

    @property
    def rank(self) -> float:
        """Importance: ten times as many robots are worth one step of urgency."""
        return URGENCY[self.kind] + math.log10(self.agents)

    @property
    def key(self) -> tuple[str, str, str]:
        """Identity of the item while the agents that it concerns come and go."""
        return self.kind.value, self.group, self.what

    def __str__(self) -> str:
        """Return the item in words, such as ``17 ants of squad_3: stuck in Search``."""
        nouns = {re.sub(r"_?[0-9]+$", "", name) for name in self.names}
        many = quantity(len(self.names), nouns.pop() if len(nouns) == 1 else "agent")
        who = self.names[0] if len(self.names) == 1 else many
        return f"{who}{f' of {self.group}' if self.group else ''}: {self.what}"

    def data(self, as_text: Callable[[Remedy], str], now: float) -> dict[str, Any]:
        """Return the item as plain data.

        Args:
            as_text: words a remedy.
            now: present time on the clock of `since`, s.
        """
        return {
            "kind": self.kind.value,
            "agents": list(self.names),
            "group": self.group,
            "what": self.what,
            "why": self.why,
            "for_s": round(max(0.0, now - self.since), 1),
            "remedies": [as_text(remedy) for remedy in self.remedies],
        }


def ranked(
    concerns: Iterable[Concern],
    superiors: Mapping[str, str],
    since: Callable[[Concern], float] = lambda concern: 0.0,
) -> list[Item]:
    """Return items for concerns, the most important first.

    Concerns are alike if they say the same of members of one group. If that is the case in most of
    the groups of a superior, they are one item of the superior.

    Args:
        concerns: the concerns.
        superiors: superior of each agent and commander, by name.
        since: returns when a concern was first made, s.
    """
    alike: dict[tuple[Kind, str], dict[str, list[Concern]]] = {}
    for concern in concerns:
        groups = alike.setdefault((concern.kind, concern.what), {})
        groups.setdefault(superiors.get(concern.name, ""), []).append(concern)
    below: dict[str, int] = {}
    for superior in {name: superiors.get(name, "") for name in {*superiors.values()}}.values():
        below[superior] = below.get(superior, 0) + 1
    items = [
        _item(kind, what, group, found, since)
        for (kind, what), groups in alike.items()
        for group, found in _merged(groups, superiors, below).items()
    ]
    return sorted(items, key=lambda item: (-item.rank, natural(item.names[0])))


def _merged(
    groups: dict[str, list[Concern]], superiors: Mapping[str, str], below: Mapping[str, int]
) -> dict[str, list[Concern]]:
    """Return concerns by group, with those of most groups of a superior under the superior."""
    while True:
        concerned: dict[str, list[str]] = {}
        for group in groups:
            if superior := superiors.get(group, ""):
                concerned.setdefault(superior, []).append(group)
        merging = {
            superior: some
            for superior, some in concerned.items()
            if len(some) > max(1, below[superior] // 2)
        }
        if not merging:
            return groups
        for superior, some in merging.items():
            together = [concern for group in some for concern in groups.pop(group)]
            groups.setdefault(superior, []).extend(together)


def _item(
    kind: Kind,
    what: str,
    group: str,
    found: list[Concern],
    since: Callable[[Concern], float],
) -> Item:
    found = sorted(found, key=lambda concern: natural(concern.name))
    first = found[0]
    names = tuple(concern.name for concern in found)
    remedies = dict.fromkeys(way for concern in found for way in concern.remedies)
    if first.teaches:
        give = partial(Fix.GIVE, agent=first.name, behavior=first.teaches)
        remedies |= dict.fromkeys(give(receiver=name) for name in names[1:])
    return Item(
        kind,
        names,
        group,
        what,
        first.why,
        min(map(since, found)),
        tuple(remedies),
        sum(concern.agents for concern in found),
        first.teaches,
    )


def others_alike(items: Iterable[Item], item: Item, agent: str) -> list[str]:
    """Return the other agents in the same situation as those of an item, in natural order.

    Args:
        items: the present items.
        item: an item, which may be over for the agent.
        agent: the agent that was corrected.
    """
    alike = {(item.kind, item.what, item.teaches)}
    names = {n for one in items if (one.kind, one.what, one.teaches) in alike for n in one.names}
    return sorted(names - {agent}, key=natural)
