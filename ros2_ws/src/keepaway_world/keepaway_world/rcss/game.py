"""The state of a server's game, cycle by cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from hitab_world import Sensed
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.percept import perceive
from keepaway_world.rcss.episode_watch import EpisodeWatch
from keepaway_world.rcss.field import Field, Place
from keepaway_world.rcss.link import Link
from keepaway_world.rcss.messages import BEFORE_KICK_OFF, EPISODE_OVER, PLAYING, FullState
from keepaway_world.referee import Referee


@dataclass(frozen=True, slots=True)
class Turn:
    """What has happened since the previous cycle.

    Attributes:
        state: the current field; None if the message was lost.
        passed: number of cycles; more than one if the server did not wait for us.
        episode_cycle: length of the episode so far.
        passes: completed in it.
        ended: why it has ended; "" if it has not.
        began: whether a new episode has begun.
    """

    state: FullState | None
    passed: int
    episode_cycle: int
    passes: int
    ended: str
    began: bool


class Game:
    """A game of keepaway, as reported to its players.

    Args:
        parameters: of the server's game.
        agents: the keepers.
        by_sight: whether keepers perceive what they see, instead of the true field.

    Attributes:
        field: the current one.
        mode: of play.
        time: the server's; -1: not known yet.
    """

    def __init__(
        self, parameters: KeepawayParameters, agents: Sequence[str], *, by_sight: bool
    ) -> None:
        self.field = Field(parameters)
        self.mode = ""
        self.time = -1
        exact = replace(parameters, sight="full")  # the server has already rounded what is seen
        self._seen = {name: Field(exact) for name in agents} if by_sight else {}
        self._watch = EpisodeWatch(Referee(parameters), self.field.physics)
        self._heard: dict[str, list[str]] = {}

    @property
    def fresh(self) -> bool:
        """Whether the current episode has not been played yet."""
        return self.time == self._watch.began

    @property
    def passes(self) -> int:
        """The number of passes completed in the current episode."""
        return self._watch.passes

    def begin(self) -> None:
        """Start an episode from the current field."""
        self._watch.begin(self.time)

    def take(self, link: Link) -> Turn:
        """Take in a cycle's messages to the players."""
        passed = max(link.time - self.time, 0) if self.time >= 0 else 0
        self.time = link.time
        state = link.state()  # None if lost: the field then stays unchanged
        mode = state.mode if state is not None else self.mode
        said = [when for when, text in link.referee if text == EPISODE_OVER]
        # A late reader takes in several cycles at once, so use the time of the message.
        at = max(said, default=self.time)
        over = bool(said)
        if state is not None and self.mode == mode == PLAYING:
            over = over or self._watch.set_up_anew(state)
        began = over or (mode == PLAYING and self.mode == BEFORE_KICK_OFF)
        ended = self._watch.why_over() if over else ""
        episode_cycle, passes = at - self._watch.began, self.passes
        if state is not None:
            kickers = self.field.take(state)
            if not began and mode == PLAYING:
                self._watch.saw(kickers)
        if began:
            self._watch.begin(at)
        for name, field in self._seen.items():
            sighting = link.clients[name].sighting
            if sighting is not None and (seen := sighting.state(mode)) is not None:
                field.take(seen)
        self._heard = {name: list(client.heard) for name, client in link.clients.items()}
        self.mode = mode
        return Turn(state, passed, episode_cycle, passes, ended, began)

    def percept(self, keeper: str) -> Sensed:
        """Return what a keeper perceives now."""
        field = self._seen.get(keeper, self.field)
        return perceive(field.physics, field.movers[keeper]), list(self._heard.get(keeper, ()))

    def put(self, places: Mapping[str, Place]) -> None:
        """Record that things were placed."""
        for field in (self.field, *self._seen.values()):
            field.put(places)
