"""The last minute of a world: it can be put back to any cycle of it.

A world is put back by restoring the last snapshot before the cycle and repeating the actions
since, so that it is then what it was, bit for bit.
"""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from hitab_core import PAST_SECONDS, HitabError
from hitab_world.simulating.lockstep import Answer
from hitab_world.world import World

SNAPSHOT_EVERY_S = 1.0
"""Simulated time between two snapshots, at least."""

SNAPSHOT_SHARE = 100
"""Time between two snapshots, at least, as a multiple of what one takes."""


class _Actions:
    """The actions of one cycle, in as few objects as can be: there may be thousands of agents."""

    def __init__(self, answers: Mapping[str, Answer], names: tuple[str, ...]) -> None:
        own = tuple(answers)
        self.names = names if own == names else own
        self._counts, self._values = array("I"), array("d")
        self._said: dict[str, str] = {}
        for name, (values, say) in answers.items():
            self._counts.append(len(values))
            self._values.extend(values)
            if say:
                self._said[name] = say

    def answers(self) -> Mapping[str, Answer]:
        """Return the actions as the world got them."""
        found: dict[str, Answer] = {}
        end = 0
        for name, count in zip(self.names, self._counts, strict=True):
            begin, end = end, end + count
            found[name] = self._values[begin:end], self._said.get(name, "")
        return found


@dataclass
class _Segment:
    """A snapshot, and the actions of the cycles after it."""

    cycle: int
    snapshot: Mapping[str, Any]
    actions: list[_Actions] = field(default_factory=list)


class LastMinute:
    """Keeps the cycles of the last minute of the present episode.

    Args:
        world: a world that does not run by itself.
        clock: function that returns the time of this machine, s.
    """

    def __init__(self, world: World, clock: Callable[[], float] = time.perf_counter) -> None:
        self._world = world
        self._clock = clock
        self._segments: list[_Segment] = []
        self._follows: tuple[int, int, int] | None = None  # the cycle after those kept
        self._cut = False
        self._earliest = 0.0
        self._names: tuple[str, ...] = ()
        self._why_not = ""  # the world gives no snapshot

    @property
    def oldest(self) -> int:
        """The first cycle that the world can be put back to; 0 if there is none."""
        if not self._segments or self._follows != self._now:
            return 0
        return max(1, self._segments[0].cycle)

    @property
    def _now(self) -> tuple[int, int, int]:
        world = self._world
        return world.seed, world.episode, world.cycle

    def cut(self) -> None:
        """Note that the world was changed other than by actions."""
        self._cut = True

    def note(self, answers: Mapping[str, Answer]) -> None:
        """Note the actions of a cycle, before the world is stepped with them."""
        world, segments, cycle = self._world, self._segments, self._world.cycle
        if self._follows != self._now:
            segments.clear()
        every = SNAPSHOT_EVERY_S / world.cycle_seconds
        is_due = bool(segments) and cycle - segments[-1].cycle >= every
        if not segments or self._cut or (is_due and self._clock() >= self._earliest):
            began = self._clock()
            try:
                snapshot = world.snapshot()
            except Exception as error:  # a world's snapshot may be third-party code
                self._why_not = f"its snapshot fails: {error!r}; correct the world"
                segments.clear()
                return
            ended = self._clock()
            segments.append(_Segment(cycle, snapshot))
            self._earliest = ended + SNAPSHOT_SHARE * (ended - began)
            self._cut, self._why_not = False, ""
        past = cycle - PAST_SECONDS / world.cycle_seconds
        while len(segments) > 1 and segments[1].cycle <= past:
            segments.pop(0)
        actions = _Actions(answers, self._names)
        self._names = actions.names
        segments[-1].actions.append(actions)
        self._follows = world.seed, world.episode, cycle + 1

    def go_back(self, cycle: int) -> None:
        """Put the world back to a cycle.

        Raises:
            HitabError: if the cycle is not one of the last minute of this episode, or if the world
                fails to play again what it has played; then nothing has changed.
        """
        world, oldest = self._world, self.oldest
        if self._why_not:
            raise HitabError(f"the world cannot go back, since {self._why_not}")
        if not oldest:
            raise HitabError("the episode has no earlier cycle yet; let the world run first")
        if not oldest <= cycle <= world.cycle:
            raise HitabError(
                f"cycle {cycle} is not one of the last minute of this episode; choose one from "
                f"{oldest} to {world.cycle}"
            )
        if cycle == world.cycle:
            return  # what was placed in it stays
        segments = [one for one in self._segments if one.cycle <= cycle]
        segment = segments[-1]
        present = world.snapshot()
        kept = segment.actions[: cycle - segment.cycle]
        try:
            world.restore(segment.snapshot)
            for actions in kept:
                world.step(actions.answers())
            if world.cycle != cycle:
                raise HitabError(f"it played cycle {world.cycle} instead of {cycle}")
        except Exception as error:
            world.restore(present)
            raise HitabError(
                f"the world cannot play again what it has played since cycle {segment.cycle}: "
                f"{error}; choose an earlier cycle, or take snapshots"
            ) from error
        segment.actions, self._segments = kept, segments
        self._follows = self._now
