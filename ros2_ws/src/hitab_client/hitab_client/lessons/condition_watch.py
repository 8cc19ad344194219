"""Sees what conditions ask for, moment by moment: in a world that is stepped, or without a world.

A simulated world is stepped cycle by cycle, and every condition is checked in every cycle. Robots
without a world are watched as time passes; nobody knows where they are, so that only what the
agents themselves report and perceive can be asked for.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Self

from hitab_msgs.msg import WorldState

from hitab_client.lessons.conditions import Condition
from hitab_client.path_tracker import PathTracker
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_client.world_view import WorldView, speakers
from hitab_ros.stamps import seconds_of

LOOK_SECONDS = 0.1
"""Between two looks at robots without a world."""


class ConditionWatch:
    """Watches the agents of a swarm that has no world; a context manager.

    Args:
        swarm: the agents.
    """

    def __init__(self, swarm: SwarmClient) -> None:
        self.swarm = swarm
        self._entered: dict[str, list[str]] = {}
        self._since = 0.0

    def __enter__(self) -> Self:
        self._tracker = PathTracker(
            self.swarm.link, self.swarm.agents(), prefix=self.swarm.prefix
        ).__enter__()
        self.begin()
        return self

    def __exit__(self, *error: object) -> None:
        self._tracker.__exit__(*error)

    def begin(self) -> None:
        """Forget what has been said, entered and ended; count the time from now."""
        self._entered = {}
        self._since = self.now()

    def now(self) -> float:
        """Return the time in the agents' world, s."""
        return time.monotonic()

    def go_on(self) -> None:
        """Let some time pass, and see what happens meanwhile."""
        self._tracker.take()
        self.swarm.link.spin_until(lambda: False, LOOK_SECONDS)
        self._entered = self._tracker.take()

    def view(self) -> WorldView:
        """Return the present moment."""
        return WorldView(None, self.now() - self._since, self._paths(), reading=self._reading)

    def _paths(self) -> dict[str, list[str]]:
        # The status may lag behind by some cycles; the states entered in this one do not.
        return {
            name: [*status.active_path, *self._entered.get(name, ())]
            for name, status in self.swarm.statuses.items()
        }

    def _reading(self, agent: str, feature: str) -> float:
        """Return the value that an agent perceives; NaN: none.

        A flag is one of the automaton that uses it as a feature: the outermost one counts.
        """
        if agent not in self.swarm.statuses:
            self.swarm.await_agent(agent)
        answer = self.swarm.read_features(agent, [feature])
        used = [r.value for r in answer.readings if r.automaton and r.feature == feature]
        asked = [r.value for r in answer.readings if not r.automaton]
        return float(used[0] if used else asked[-1])

    def until(
        self,
        condition: Condition,
        within: float,
        seen: Callable[[WorldView], None] = lambda view: None,
    ) -> bool:
        """Let time pass until a condition holds; return whether it came to hold in time.

        Args:
            condition: what is awaited.
            within: how long, s of the agents' world.
            seen: called with each moment.
        """
        while not condition.holds(view := self.view()):
            seen(view)
            if view.seconds >= within:
                return False
            self.go_on()
        return True


class WorldWatch(ConditionWatch):
    """Watches a paused world and steps it.

    Args:
        swarm: the agents.
        world: their world, which is paused.
        factor: multiple of real time, for people who look on; 0: as fast as possible.
    """

    def __init__(self, swarm: SwarmClient, world: WorldClient, *, factor: float = 0.0) -> None:
        super().__init__(swarm)
        self.world = world
        self._factor = factor
        self._said: frozenset[str] = frozenset()
        self._ended: tuple[str, ...] = ()
        self._due = 0.0

    def begin(self) -> None:
        """Forget what has been said, entered and ended; count the time from now."""
        super().begin()
        self._said, self._ended = frozenset(), ()

    @property
    def state(self) -> WorldState:
        """The present state of the world."""
        assert self.world.state is not None
        return self.world.state

    def now(self) -> float:
        """Return the world's time, s."""
        return seconds_of(self.state.header.stamp)

    def go_on(self) -> None:
        """Run one cycle, no faster than ``factor`` allows."""
        earlier = self.state
        self._tracker.take()
        state = self.world.step()
        self._entered = self._tracker.take()
        self._said |= speakers(state.entities)
        if state.note and state.note not in (earlier.note, "reset"):
            self._ended += (state.note,)
        if self._factor:
            now = time.monotonic()
            self._due = max(self._due, now - 0.5)
            passed = seconds_of(state.header.stamp) - seconds_of(earlier.header.stamp)
            self._due += max(0.0, passed) / self._factor
            self.swarm.link.spin_until(lambda: False, self._due - now)

    def view(self) -> WorldView:
        """Return the present moment."""
        return WorldView(
            self.state.entities,
            self.now() - self._since,
            self._paths(),
            self._said,
            self._ended,
            reading=self._reading,
        )
