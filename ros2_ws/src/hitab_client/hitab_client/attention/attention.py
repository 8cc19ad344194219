"""What deserves a look, from one look at a swarm to the next."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from hitab_client.attention import concerns
from hitab_client.attention.items import Concern, Item, Kind, ranked
from hitab_client.attention.stillness import Place, Stillness
from hitab_ros.timing import PROMPT_S, REPEAT_S


@dataclass(frozen=True)
class Seen:
    """What was heard of a swarm, at one moment.

    Attributes:
        statuses: last `AgentStatus` of each agent and commander, by name.
        groups: last `CommanderStatus` of each commander, by name.
        silent: names that give no signs of life, with the time since the last sign, s.
        missing: agents for which the world gets no answers.
        places: positions, m, by name, where they are known.
        seconds: time of the swarm's world, s; without a world, of the machine's clock.
        machines: last `MachineStatus` of each machine, by name.
        silent_machines: silent machines, with the time since the last sign, s.
    """

    statuses: Mapping[str, Any]
    groups: Mapping[str, Any]
    silent: Mapping[str, float]
    missing: frozenset[str] = frozenset()
    places: Mapping[str, Place] = field(default_factory=dict)
    seconds: float = 0.0
    machines: Mapping[str, Any] = field(default_factory=dict)
    silent_machines: Mapping[str, float] = field(default_factory=dict)


class Attention:
    """Remembers since when each concern lasts, and who got nowhere.

    What is over within a moment deserves no look, such as an order that has not arrived yet.

    Attributes:
        items: the items at the last look, the most important first.
    """

    def __init__(self, process_of: Callable[[str], str] = str) -> None:
        """Begin to watch.

        Args:
            process_of: returns the process that runs an agent.
        """
        self.items: list[Item] = []
        self._process_of = process_of
        self._stillness = Stillness()
        self._next_sample = 0.0
        self._since: dict[tuple[Kind, str], float] = {}

    def look(self, seen: Seen, now: float) -> list[Item]:
        """Return what deserves a look, the most important first.

        Args:
            seen: what was heard of the swarm.
            now: present time on the monotonic clock, s.
        """
        found = _one_each(self._found(seen))
        self._since = {
            (one.kind, one.name): self._since.get((one.kind, one.name), now) for one in found
        }
        lasting = [one for one in found if now - self._began(one) >= PROMPT_S]
        superiors = concerns.superiors_of(seen.statuses, seen.groups)
        self.items = ranked(lasting, superiors, self._began)
        return self.items

    def _began(self, concern: Concern) -> float:
        return self._since[concern.kind, concern.name]

    def _found(self, seen: Seen) -> Iterator[Concern]:
        away = {*seen.silent, *seen.missing}
        statuses = {name: s for name, s in seen.statuses.items() if name not in away}
        groups = {name: group for name, group in seen.groups.items() if name not in away}
        if not 0.0 <= self._next_sample - seen.seconds <= REPEAT_S:
            self._next_sample = seen.seconds + REPEAT_S
            self._stillness.take(seen.seconds, concerns.doings(statuses, seen.groups), seen.places)
        still = {n: how for n, how in self._stillness.stuck().items() if n in statuses}
        yield from concerns.absent(seen.silent, seen.missing, self._process_of)
        yield from concerns.machines(seen.machines, seen.silent_machines)
        yield from concerns.faulty(statuses)
        yield from concerns.disobeying(statuses, groups)
        yield from concerns.stuck(statuses, still)
        yield from concerns.unarmed(statuses)
        yield from concerns.unsure(statuses)
        yield from concerns.differing(statuses, seen.groups)


def _one_each(concerns: Iterable[Concern]) -> list[Concern]:
    """Return the most urgent concern of each name, which also tells the others."""
    found: dict[str, Concern] = {}
    for other in concerns:
        first = found.setdefault(other.name, other)
        if first is not other:
            why = "; ".join(filter(None, (first.why, other.what)))
            found[other.name] = replace(first, why=why, remedies=first.remedies + other.remedies)
    return [*found.values()]
