"""The command hierarchy of a swarm, as the commanders report it on their topics."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hitab_msgs.msg import CommanderStatus, Subordinate

from hitab_client.connecting.ros_link import RosLink
from hitab_client.showing.swarm_listener import SwarmListener
from hitab_core import some
from hitab_ros import names, qos
from hitab_ros.names import GROUP
from hitab_ros.timing import POLL_S

GROUP_TYPE = "hitab_msgs/msg/CommanderStatus"


class CommanderView(SwarmListener):
    """Listens to all commanders of a swarm.

    Args:
        link: the node to use.
        prefix: namespace of the swarm.
        identity: the swarm's identity; empty for any swarm.

    Attributes:
        groups: each commander's latest report about its group, by name.
        incomplete: the watched commanders that have not heard from all their subordinates yet.
    """

    def __init__(self, link: RosLink, prefix: str = "", identity: str = "") -> None:
        super().__init__(link, prefix, identity)
        self.groups: dict[str, CommanderStatus] = {}
        self.incomplete: dict[str, None] = {}
        self._watched: set[str] = set()

    def discover(self) -> None:
        """Look for new commanders."""
        ending = f"/{GROUP}"
        for topic in self.link.topics_of_type(GROUP_TYPE):
            if not topic.startswith(self.prefix + "/") or not topic.endswith(ending):
                continue
            name = topic[len(self.prefix) + 1 : -len(ending)]
            if "/" not in name:
                self.watch([name])

    def watch(self, commanders: Iterable[str]) -> None:
        """Start listening to commanders."""
        for commander in set(commanders) - self._watched:
            self._watched.add(commander)
            self.incomplete[commander] = None
            topic = names.of_agent(commander, GROUP, self.prefix)
            self.link.subscribe(CommanderStatus, topic, self._take, qos.LATCHED)

    def _take(self, group: CommanderStatus) -> None:
        if self._is_own(group.commander, group.swarm):
            self.groups[group.commander] = group
            if any(member.silent for member in group.subordinates):
                self.incomplete[group.commander] = None
            else:
                self.incomplete.pop(group.commander, None)

    def await_groups(self, seconds: float, expected: Iterable[str] = ()) -> None:
        """Wait until all commanders, discovered or expected, have reported."""
        wanted = set(expected)
        self.watch(wanted)

        def complete() -> bool:
            if not wanted:
                self.discover()
            known = wanted or self._watched
            return bool(known) and known <= self.groups.keys() | self.strangers.keys()

        def missing() -> str:
            return some(sorted(wanted - self.groups.keys())) or "commanders to appear"

        if not self.link.spin_until(complete, seconds, waiting_for=missing) or not wanted:
            # A commander discovered a little later belongs in the tree, too.
            self.link.spin_until(lambda: False, POLL_S)
            self.discover()
            self.link.spin_until(lambda: self._watched <= self.groups.keys(), POLL_S)


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
