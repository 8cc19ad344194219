"""A recorded run, to view moment by moment."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hitab_msgs.msg import AgentStatus, Episode, TransitionEvent, WorldState
from mcap.exceptions import McapError
from mcap.reader import make_reader
from rclpy.serialization import deserialize_message

from hitab_client import SwarmError
from hitab_core import newer_format
from hitab_studio.recording import FORMAT, METADATA
from hitab_studio.scene import Scene, scene_of, state_shown

NANOSECONDS = 1e9
STATE, STATUS = "hitab_msgs/msg/WorldState", "hitab_msgs/msg/AgentStatus"
TRANSITION, EPISODE = "hitab_msgs/msg/TransitionEvent", "hitab_msgs/msg/Episode"


@dataclass
class _Line:
    """Messages of one topic in order of arrival, deserialized on access."""

    times: list[float] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)

    def add(self, seconds: float, data: bytes) -> None:
        self.times.append(seconds)
        self.data.append(data)

    def last(self, seconds: float) -> bytes | None:
        """Return the last message until then."""
        i = bisect_right(self.times, seconds)
        return self.data[i - 1] if i else None


class Recording:
    """One recording, in memory."""

    def __init__(self, path: Path) -> None:
        """Read a recording.

        Raises:
            SwarmError: if it cannot be read, or shows no world.
        """
        self.path = path
        self.start = self.seconds = 0.0
        self._states = _Line()
        self._statuses: dict[str, _Line] = {}
        self._events = _Line()
        self.episodes: list[tuple[float, str]] = []
        try:
            with path.open("rb") as file:
                self._read(make_reader(file))
        except (OSError, McapError, ValueError) as error:
            raise SwarmError(f"{path.name} cannot be read: {error}") from None
        if not self._states.times:
            raise SwarmError(f"{path.name} shows no world: nothing to replay")
        self.start = self._states.times[0]
        self.seconds = self._states.times[-1] - self.start

    def _read(self, reader: Any) -> None:
        for metadata in reader.iter_metadata():
            found = metadata.metadata.get("format", "1") if metadata.name == METADATA else "1"
            if not found.isdecimal() or int(found) > FORMAT:
                raise SwarmError(f"{self.path.name} {newer_format(found, FORMAT)}")
        for schema, channel, message in reader.iter_messages():
            seconds = message.log_time / NANOSECONDS
            match schema.name:
                case name if name == STATE:
                    self._states.add(seconds, message.data)
                case name if name == STATUS:
                    agent = channel.topic.split("/")[-2]
                    self._statuses.setdefault(agent, _Line()).add(seconds, message.data)
                case name if name == TRANSITION:
                    self._events.add(seconds, message.data)
                case name if name == EPISODE:
                    episode = deserialize_message(message.data, Episode)
                    self.episodes.append((seconds, episode.ended))

    def scene(self, seconds: float) -> Scene:
        """Return the scene this many seconds after the beginning."""
        data = self._states.last(self.start + seconds) or self._states.data[0]
        return scene_of(deserialize_message(data, WorldState))

    def statuses(self, seconds: float) -> dict[str, Any]:
        """Return the status of each agent at that time."""
        found = {}
        for agent, line in self._statuses.items():
            data = line.last(self.start + seconds)
            if data is not None:
                found[agent] = deserialize_message(data, AgentStatus)
        return found

    def doing(self, seconds: float) -> dict[str, tuple[str, str]]:
        """Return the mode and the active state of each agent at that time."""
        return {
            agent: (s.mode, state_shown(s.active_path))
            for agent, s in self.statuses(seconds).items()
        }

    def events(self, seconds: float, agent: str, count: int = 12) -> list[Any]:
        """Return an agent's last state changes until then, newest first."""
        found: list[Any] = []
        i = bisect_right(self._events.times, self.start + seconds)
        while i and len(found) < count:
            i -= 1
            event = deserialize_message(self._events.data[i], TransitionEvent)
            if not agent or event.agent == agent:
                found.append(event)
        return found


@dataclass
class Player:
    """Plays a recording for one page.

    Attributes:
        at: seconds since the beginning.
        playing: whether it is playing.
        speed: of playback.
    """

    recording: Recording
    at: float = 0.0
    playing: bool = True
    speed: float = 1.0

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
