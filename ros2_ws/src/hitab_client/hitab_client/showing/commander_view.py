"""The command hierarchy of a swarm, as the commanders report it on their topics."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hitab_msgs.msg import CommanderStatus, Subordinate

from hitab_client.showing.agent_presence import WATCHED_MAX, AgentPresence
from hitab_client.showing.swarm_listener import SwarmListener
from hitab_core import some
from hitab_ros import names, qos
from hitab_ros.names import GROUP
from hitab_ros.timing import POLL_S, UPDATE_S

GROUP_TYPE = "hitab_msgs/msg/CommanderStatus"


class CommanderView(SwarmListener):
    """Listens to all commanders of a swarm.

    Args:
        agents: the agents of the swarm.

    Attributes:
        groups: each commander's latest report about its group, by name.
        reports: number of reports so far.
        incomplete: the watched commanders that have not heard from all their subordinates yet.
    """

    def __init__(self, agents: AgentPresence) -> None:
        super().__init__(agents.link, agents.prefix, agents.identity)
        self._agents = agents
        self.groups: dict[str, CommanderStatus] = {}
        self.reports = 0
        self.incomplete: dict[str, None] = {}
        self._watched: set[str] = set()
        self._unheard: dict[str, None] = {}
        self._hears_hosts = False

    def discover(self) -> None:
        """Look for new commanders, in hosts and elsewhere."""
        self._hear_hosts()
        ending = f"/{GROUP}"
        for topic in self.link.topics_of_type(GROUP_TYPE):
            if not topic.startswith(self.prefix + "/") or not topic.endswith(ending):
                continue
            name = topic[len(self.prefix) + 1 : -len(ending)]
            if "/" not in name and not self._agents.is_hosted(name):
                self.watch([name])

    def watch(self, commanders: Iterable[str]) -> None:
        """Start listening to commanders: to many in hosts on one topic, to others on their own."""
        new = [name for name in dict.fromkeys(commanders) if name not in self._watched]
        self._watched.update(new)
        self._unheard.update(dict.fromkeys(name for name in new if name not in self.groups))
        self.incomplete.update(dict.fromkeys(new))
        if len(new) > WATCHED_MAX:
            self._hear_hosts()
            new = [name for name in new if not self._agents.is_hosted(name)]
        for commander in new:
            topic = names.of_agent(commander, GROUP, self.prefix)
            self.link.subscribe(CommanderStatus, topic, self._take, qos.LATCHED)

    def _hear_hosts(self) -> None:
        if not self._hears_hosts:
            self._hears_hosts = True
            self._agents.hear_groups(self._take)

    def _take(self, group: CommanderStatus) -> None:
        name = group.commander
        self._unheard.pop(name, None)
        if self._is_own(name, group.swarm):
            self.groups[name] = group
            self.reports += 1
            if not any(member.silent for member in group.subordinates):
                self.incomplete.pop(name, None)
            elif name in self._watched:
                self.incomplete[name] = None

    def await_groups(self, seconds: float, expected: Iterable[str] = ()) -> None:
        """Wait until all commanders, discovered or expected, have reported."""
        wanted = list(expected)
        self.watch(wanted)
        next_look = time.monotonic()

        def complete() -> bool:
            nonlocal next_look
            if not wanted and time.monotonic() >= next_look:
                self.discover()
                next_look = time.monotonic() + UPDATE_S
            return bool(self._watched or self.groups) and not self._unheard

        def missing() -> str:
            return some(sorted(self._unheard)) or "commanders to appear"

        if not self.link.spin_until(complete, seconds, waiting_for=missing) or not wanted:
            # A commander discovered a little later belongs in the tree, too.
            self.link.spin_until(lambda: False, POLL_S)
            self.discover()
            self.link.spin_until(lambda: not self._unheard, POLL_S)


@dataclass(frozen=True)
class Branch:
    """A commander or an agent, with its subordinates.

    Attributes:
        behavior: the performed top-level behavior; empty if none.
        path: active states of a commander.
        order: a commander's current order; empty if none.
        obeys: whether it performs its own commander's order; None if it has no commander.
        silent: whether its commander has missed its heartbeat.
        stopped: whether its robot may not act.
        counts: numbers of a commander's subordinates: obeying, total.
        leaves: numbers of all agents below: obeying, total. An agent counts as obeying if it
            and every commander in between obey.
        faults: a commander's persistent faults.
    """

    name: str
    behavior: str = ""
    path: tuple[str, ...] = ()
    order: str = ""
    mode: str = ""
    obeys: bool | None = None
    silent: bool = False
    stopped: bool = False
    below: tuple[Branch, ...] = ()
    counts: tuple[int, int] = (0, 0)
    leaves: tuple[int, int] = field(default=(0, 0))
    faults: tuple[str, ...] = ()

    @property
    def is_commander(self) -> bool:
        """Whether the branch has subordinates."""
        return bool(self.below)

    def commanders(self) -> Iterator[Branch]:
        """Yield the commanders of this branch, from the top."""
        if self.is_commander:
            yield self
        for branch in self.below:
            yield from branch.commanders()

    def data(self) -> dict[str, Any]:
        """Return the branch as plain data."""
        plain: dict[str, Any] = {
            "name": self.name,
            "behavior": self.behavior,
            "obeys": self.obeys,
            "silent": self.silent,
            "stopped": self.stopped,
        }
        if self.is_commander:
            plain |= {
                "mode": self.mode,
                "active_path": list(self.path),
                "order": self.order,
                "performing": self.counts[0],
                "of": self.counts[1],
                "agents_performing": self.leaves[0],
                "agents": self.leaves[1],
                "faults": list(self.faults),
                "subordinates": [branch.data() for branch in self.below],
            }
        return plain


def tree_of(groups: Mapping[str, CommanderStatus]) -> list[Branch]:
    """Return the trees of these commanders' groups."""
    commanded = {member.name for group in groups.values() for member in group.subordinates}
    return [_branch(name, groups, ()) for name in sorted(groups) if name not in commanded]


def _branch(
    name: str,
    groups: Mapping[str, CommanderStatus],
    above: tuple[str, ...],
    seen: Subordinate | None = None,
) -> Branch:
    """Return a branch; ``seen`` is how its own commander sees it."""
    fields = ("obeys", "silent", "stopped") if seen is not None else ()
    reported: dict[str, Any] = {one: getattr(seen, one) for one in fields}
    group = groups.get(name)
    if group is None or name in above:
        return Branch(
            name, seen.behavior if seen else "", **reported, leaves=(int(reported["obeys"]), 1)
        )
    below = tuple(_branch(m.name, groups, (*above, name), m) for m in group.subordinates)
    leaves = [b.leaves if b.obeys else (0, b.leaves[1]) for b in below]
    return Branch(
        name,
        group.behavior,
        tuple(group.active_path),
        group.order,
        group.mode,
        **reported,
        below=below,
        counts=(sum(bool(b.obeys) for b in below), len(below)),
        leaves=(sum(performing for performing, _ in leaves), sum(count for _, count in leaves)),
        faults=tuple(group.faults),
    )
