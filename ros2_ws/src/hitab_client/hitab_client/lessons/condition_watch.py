"""Evaluation of conditions over time, in a stepped world or without a world.

A simulated world is stepped cycle by cycle, and every condition is checked in every cycle. Robots
without a world are watched in real time; their positions are unknown, so conditions are limited to
reports and percepts of the agents.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Self

from hitab_msgs.msg import TransitionEvent, WorldState

from hitab_client.lessons.conditions import Condition
from hitab_client.showing.world_view import WorldView, speakers
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_ros import names, qos
from hitab_ros.messages.stamps import seconds_of
from hitab_ros.timing import UPDATE_S


class ConditionWatch:
    """Watches the agents of a swarm; a context manager, since watching costs the agents time.

    Statuses of agents contain the active states, but arrive only at intervals. Transitions
    report every change, so that no short-lived state is missed.

    Args:
        swarm: client of the agents.
        world: client of the agents' world, which is paused and stepped here; None without a
            world.
        factor: multiple of real time, for human viewers; 0 for full speed.
    """

    def __init__(
        self, swarm: SwarmClient, world: WorldClient | None = None, *, factor: float = 0.0
    ) -> None:
        self._swarm = swarm
        self._world = world
        self._factor = factor
        self._due = 0.0
        self._subscriptions: list[Any] = []
        self._passed: dict[str, list[str]] = {}

    def __enter__(self) -> Self:
        link = self._swarm.link
        topics = [
            names.of_agent(agent, names.TRANSITIONS, self._swarm.prefix)
            for agent in self._swarm.agents()
        ]
        self._subscriptions = [
            link.subscribe(TransitionEvent, topic, self._take, qos.EVENTS, temporary=True)
            for topic in topics
        ]
        link.spin_until(lambda: all(map(link.node.count_publishers, topics)), 3.0, 0.01)
        self.begin()
        return self

    def __exit__(self, *error: object) -> None:
        for subscription in self._subscriptions:
            self._swarm.link.node.destroy_subscription(subscription)

    def _take(self, event: TransitionEvent) -> None:
        self._passed.setdefault(event.agent, []).append(event.to_state)

    def begin(self) -> None:
        """Discard past messages, entered states and ended episodes; count the time from now."""
        self._entered: dict[str, list[str]] = {}
        self._said: frozenset[str] = frozenset()
        self._ended: tuple[str, ...] = ()
        self._since = self.now()

    def now(self) -> float:
        """Return the time in the agents' world, s."""
        if self._world is None:
            return time.monotonic()
        assert self._world.state is not None
        return seconds_of(self._world.state.header.stamp)

    def go_on(self) -> None:
        """Watch for one period, or for one cycle of the world."""
        self._passed = {}
        if self._world is None:
            self._swarm.link.spin_until(lambda: False, UPDATE_S)
            self._entered = self._passed
            return
        earlier, before = self._world.state, self.now()
        state = self._world.step()
        self._entered = self._passed
        self._said |= speakers(state.entities)
        if state.note and state.note not in (getattr(earlier, "note", ""), "reset"):
            self._ended += (state.note,)
        if self._factor:
            now = time.monotonic()
            self._due = max(self._due, now - 0.5) + max(0.0, self.now() - before) / self._factor
            self._swarm.link.spin_until(lambda: False, self._due - now)

    def view(self) -> WorldView:
        """Return the present moment."""
        state: WorldState | None = None if self._world is None else self._world.state
        return WorldView(
            None if state is None else state.entities,
            self.now() - self._since,
            # The status may lag behind by some cycles; states entered in this cycle do not.
            {
                name: [*status.active_path, *self._entered.get(name, ())]
                for name, status in self._swarm.statuses.items()
            },
            self._said,
            self._ended,
            reading=self._reading,
        )

    def _reading(self, agent: str, feature: str) -> float:
        """Return a feature's value as an agent perceives it; NaN without a value.

        Flags belong to the automaton that uses them as features; the outermost one counts.
        """
        if agent not in self._swarm.statuses:
            self._swarm.await_agent(agent)
        answer = self._swarm.read_features(agent, [feature])
        used = [r.value for r in answer.readings if r.automaton and r.feature == feature]
        values = [r.value for r in answer.readings if not r.automaton]
        return float(used[0] if used else values[-1])

    def until(
        self,
        condition: Condition,
        within: float,
        seen: Callable[[WorldView], None] = lambda view: None,
    ) -> bool:
        """Watch until a condition holds; return whether it holds in time.

        Args:
            condition: condition to wait for.
            within: timeout, s of the agents' world.
            seen: called with each view.
        """
        while not condition.holds(view := self.view()):
            seen(view)
            if view.seconds >= within:
                return False
            self.go_on()
        return True
