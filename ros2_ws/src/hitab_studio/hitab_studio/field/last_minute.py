"""The last minute of the swarm: what the agents did, and how the field looked."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from hitab_msgs.msg import Preview

from hitab_core import PAST_SECONDS
from hitab_studio.field.remembered_scenes import RememberedScenes
from hitab_studio.field.scene import Scene, state_shown

GLIMPSES_MAX = 60_000
"""Maximum number of remembered glimpses of all agents together; one takes about 300 bytes."""

EVENTFUL_MAX = 50
"""Maximum number of agents whose last mark is remembered."""

COMMAND, QUESTION, UNSURE, HELD = "command", "question", "unsure", "held"


NO_PREVIEW = Preview()


class Glimpse(NamedTuple):
    """What the status of an agent told, from a moment on.

    Attributes:
        at: the moment, see `Minute`.
        mode: as in `AgentStatus`.
        state: the state that determines its color; "" if none.
        path: its active states, outermost first.
        unsure: why it is unsure; "" if it is sure.
        held: the breakpoint that it met; "" if none.
        examples, questions: numbers of examples and of open questions of its training.
        by: who commanded it last.
    """

    at: float
    mode: str
    state: str
    path: tuple[str, ...]
    unsure: str
    held: str
    examples: int
    questions: int
    by: str

    @classmethod
    def of(cls, status: Any, at: float) -> Glimpse:
        """Return what a status tells."""
        training = status.training
        preview = preview_in(status)
        return cls(
            at,
            status.mode,
            state_shown(status),
            tuple(status.active_path),
            status.caution.unsure or preview.unsure,
            getattr(status, "held", ""),
            training.examples,
            training.questions,
            training.demonstrator,
        )


def preview_in(status: Any) -> Any:
    """Return the `Preview` in a status; an empty one in those of old recordings."""
    return getattr(status, "preview", NO_PREVIEW)


class Mark(NamedTuple):
    """What happened at a moment: its kind and, for people, a text."""

    at: float
    kind: str
    text: str


def marks(glimpses: Iterable[Glimpse]) -> Iterator[Mark]:
    """Yield what happened between glimpses: commands, questions, unsure moments and holds."""
    before: Glimpse | None = None
    for now in glimpses:
        if before is not None:
            if now.examples > before.examples:
                yield Mark(now.at, COMMAND, f"commanded by {now.by or 'somebody'}")
            if now.questions > before.questions:
                yield Mark(now.at, QUESTION, "has a question")
            if now.unsure and not before.unsure:
                yield Mark(now.at, UNSURE, f"unsure: {now.unsure}")
            if now.held and not before.held:
                yield Mark(now.at, HELD, f"held: {now.held}")
        before = now


class Minute:
    """Remembers the field and the agents' doing, so that a person can look back.

    A moment is a number: the world's cycle, or with real robots, which have no common cycle, the
    time on the monotonic clock, s. When a world goes back, what came after is forgotten.

    Args:
        scenes: remembers the scenes.

    Attributes:
        now: the newest moment.
        rate: moments per second: cycles in a simulated second, or 1.
        episodes: moments at which episodes began.
        eventful: agents with marks, the one with the newest mark last.
    """

    def __init__(self, scenes: RememberedScenes | None = None) -> None:
        self.scenes = scenes or RememberedScenes()
        self.now, self.rate = 0.0, 1.0
        self.episodes: deque[float] = deque(maxlen=100)
        self.eventful: dict[str, float] = {}
        self._glimpses: dict[str, deque[Glimpse]] = {}
        self._cycles: dict[str, deque[tuple[float, int]]] = {}
        self._last: Scene | None = None

    @property
    def begin(self) -> float:
        """The earliest moment to which a person can look back."""
        moments = self.scenes.moments
        return max(self.now - PAST_SECONDS * self.rate, moments[0] if moments else self.now)

    def see(self, scene: Scene, at: float) -> None:
        """Remember how the field looks now."""
        last, self._last = self._last, scene
        self.scenes.see(scene, at)
        if at < self.now:
            for agent, line in self._glimpses.items():
                self._glimpses[agent] = deque((g for g in line if g.at <= at), line.maxlen)
            self.episodes = deque((e for e in self.episodes if e <= at), self.episodes.maxlen)
        if last is not None and scene.episode != last.episode:
            self.episodes.append(at)
        if last is not None and scene.cycle > last.cycle and scene.seconds > last.seconds:
            self.rate = (scene.cycle - last.cycle) / (scene.seconds - last.seconds)
        self.now = at

    def hear(self, agent: str, status: Any, at: float, agents: int = 1) -> None:
        """Remember what the status of one of so many agents tells."""
        line = self._glimpses.get(agent)
        if line is None:
            most = max(20, min(600, GLIMPSES_MAX // max(1, agents)))
            line = self._glimpses[agent] = deque(maxlen=most)
        while line and line[-1].at > at:
            line.pop()
        glimpse = Glimpse.of(status, at)
        if line and line[-1]._replace(at=at) == glimpse:
            return
        if line and any(marks((line[-1], glimpse))):
            self.eventful.pop(agent, None)
            self.eventful[agent] = at
            if len(self.eventful) > EVENTFUL_MAX:
                self.eventful.pop(next(iter(self.eventful)))
        line.append(glimpse)

    def hear_cycle(self, agent: str, cycle: int, at: float) -> None:
        """Remember a robot's own cycle at a moment."""
        line = self._cycles.setdefault(agent, deque(maxlen=600))
        if not line or line[-1] != (at, cycle):
            line.append((at, cycle))

    def cycle(self, agent: str, at: float, *, real: bool) -> int:
        """Return an agent's cycle at a moment; 0 if unknown."""
        if not real:
            return int(at)
        known = self._cycles.get(agent, ())
        times, cycles = [time for time, _ in known], [cycle for _, cycle in known]
        return round(np.interp(at, times, cycles)) if known else 0

    def glimpses(self, agent: str) -> Sequence[Glimpse]:
        """Return the glimpses of an agent, oldest first."""
        return self._glimpses.get(agent, ())

    def doing(self, at: float) -> dict[str, tuple[str, str]]:
        """Return the mode and the state of each agent at a moment, as `SwarmState.doing`."""
        found = {agent: glimpse_at(line, at) for agent, line in self._glimpses.items()}
        return {agent: (g.mode, g.state) for agent, g in found.items() if g is not None}


def glimpse_at(glimpses: Sequence[Glimpse], at: float) -> Glimpse | None:
    """Return the glimpse that held at a moment; None before the first one."""
    number = bisect_right(glimpses, at, key=lambda glimpse: glimpse.at)
    return glimpses[number - 1] if number else None
