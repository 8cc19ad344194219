"""Replay of a recorded run, moment by moment."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from hitab_msgs.msg import AgentStatus, Episode, TransitionEvent, WorldState

from hitab_client import SwarmError
from hitab_client.recording import Received, RecordedMessages, type_name
from hitab_core.labeling import Strip
from hitab_studio.field.last_minute import Glimpse
from hitab_studio.field.scene import Scene, scene_of
from hitab_studio.swarm.swarm_state import SwarmState

REPLAYED = {type_name(kind): kind for kind in (WorldState, AgentStatus, TransitionEvent, Episode)}
STATE, STATUS, _, EPISODE = REPLAYED


@dataclass
class _Line:
    """Messages of one topic in order of arrival, decoded on access."""

    times: list[float] = field(default_factory=list)
    _messages: list[Received] = field(default_factory=list)
    _last: tuple[int, Any] = (-1, None)

    def add(self, seconds: float, message: Received) -> None:
        if not self.times:
            message.decoded()  # raises now rather than during the replay
        self.times.append(seconds)
        self._messages.append(message)

    def last(self, seconds: float) -> Any:
        """Return the last message until that time; None if there is none.

        The message is cached, since a page requests the same one many times.
        """
        i = bisect_right(self.times, seconds) - 1
        if i != self._last[0]:
            self._last = i, self._decoded(i)
        return self._last[1]

    def until(self, seconds: float) -> Iterator[Any]:
        """Yield the messages until that time, newest first."""
        for i in range(bisect_right(self.times, seconds) - 1, -1, -1):
            yield self._decoded(i)

    def between(self, begin: float, end: float) -> Iterator[tuple[float, Any]]:
        """Yield times and messages: the one that holds at the beginning, and all until the end."""
        first = max(0, bisect_right(self.times, begin) - 1)
        for i in range(first, bisect_right(self.times, end)):
            yield self.times[i], self._decoded(i)

    def _decoded(self, i: int) -> Any:
        return None if i < 0 else self._messages[i].decoded()


class Recording:
    """One recording, in memory.

    Attributes:
        missing: the missing part of an unfinished file; "" if there is none.
    """

    def __init__(self, path: Path) -> None:
        """Read a recording.

        Raises:
            SwarmError: if the file cannot be read, or contains no world.
        """
        self.path = path
        self.start = self.seconds = 0.0
        self._states = _Line()
        self._statuses: dict[str, _Line] = {}
        self._events = _Line()
        self.episodes: list[tuple[float, str]] = []
        self._window = (0.0, 0.0)
        self._glimpses: dict[str, list[Glimpse]] = {}
        messages = RecordedMessages(path)
        self._read(messages)
        self.missing = messages.missing
        if not self._states.times:
            raise SwarmError(f"{path.name} shows no world: nothing to replay")
        self.start = self._states.times[0]
        self.seconds = self._states.times[-1] - self.start

    def _read(self, messages: Iterable[Received]) -> None:
        for message in messages:
            name = message.schema.name
            if name not in REPLAYED:
                continue
            seconds = message.received / 1e9
            if name == EPISODE:
                self.episodes.append((seconds, message.decoded().ended))
                continue
            line = self._states if name == STATE else self._events
            if name == STATUS:
                line = self._statuses.setdefault(message.topic.split("/")[-2], _Line())
            line.add(seconds, message)

    def scene(self, seconds: float) -> Scene:
        """Return the scene this many seconds after the beginning."""
        return scene_of(self._states.last(max(self.start + seconds, self.start)))

    def statuses(self, seconds: float) -> dict[str, Any]:
        """Return the status of each agent at that time."""
        last = {agent: line.last(self.start + seconds) for agent, line in self._statuses.items()}
        return {agent: status for agent, status in last.items() if status is not None}

    def events(self, seconds: float, agent: str, count: int = 12) -> list[Any]:
        """Return an agent's last state changes until that time, newest first."""
        events = self._events.until(self.start + seconds)
        return list(islice((e for e in events if not agent or e.agent == agent), count))

    def glimpses(self, agent: str, begin: float, end: float) -> list[Glimpse]:
        """Return what an agent did between two times; kept until others are asked for."""
        if self._window != (begin, end):
            self._window, self._glimpses = (begin, end), {}
        if agent not in self._glimpses:
            line = self._statuses.get(agent, _Line())
            self._glimpses[agent] = [
                Glimpse.of(status, at - self.start)
                for at, status in line.between(self.start + begin, self.start + end)
            ]
        return self._glimpses[agent]

    def beside(self, seconds: float, step: int) -> float:
        """Return the time of the scene that is some scenes after the one shown at a time."""
        times = self._states.times
        number = bisect_right(times, self.start + seconds + 1e-9) - 1 + step
        return times[min(max(number, 0), len(times) - 1)] - self.start


@dataclass
class Labels:
    """Labels of an agent's moments in a recording: the behavior of each.

    Attributes:
        strip: the labeled moments.
        offset: time of the first moment, s after the beginning of the recording.
        chosen: number of the selected span; -1 if none.
    """

    strip: Strip
    offset: float
    chosen: int = -1


@dataclass
class ReplayPlayer:
    """Plays a recording for one page.

    Attributes:
        at: shown time, s since the beginning.
        playing: whether the time advances.
        speed: factor of the playback speed.
        labels: labels of one agent; None before a person requests them.
    """

    recording: Recording
    at: float = 0.0
    playing: bool = True
    speed: float = 1.0
    labels: Labels | None = None
    _state: tuple[float, SwarmState] = (-1.0, SwarmState())

    @property
    def state(self) -> SwarmState:
        """The state of the swarm at the shown time."""
        if self.at != self._state[0]:
            scene, statuses = self.recording.scene(self.at), self.recording.statuses(self.at)
            self._state = self.at, SwarmState(scene=scene, statuses=statuses)
        return self._state[1]

    def advance(self, seconds: float) -> bool:
        """Advance the time; return whether the moment changed."""
        if not self.playing:
            return False
        self.at = min(self.at + self.speed * seconds, self.recording.seconds)
        if self.at >= self.recording.seconds:
            self.playing = False
        return True

    def seek(self, at: float) -> None:
        """Go to a moment."""
        self.at = max(0.0, min(at, self.recording.seconds))
