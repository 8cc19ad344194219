"""Soccer on a running rcssserver, with the interface of all worlds.

The server owns time and everything on the field; this world sends its players' commands and
reports the server's messages. See docs/rcssserver.md for the limits of such a world.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable, Mapping
from random import Random
from typing import Any

from rclpy.node import Node

from hitab_core import world_seed
from hitab_rcssserver import sentences
from hitab_rcssserver.connection import NoAnswer, ServerError, kick_off
from hitab_rcssserver.field import parameters_of
from hitab_rcssserver.game import ReportedGame, Turn
from hitab_rcssserver.link import SERVER_WAIT_S, Link
from hitab_rcssserver.messages import BEFORE_KICK_OFF, PLAYING, command_of, say
from hitab_rcssserver.offline_trainer import OfflineTrainer
from hitab_rcssserver.server_settings import SEE, ServerSettings
from hitab_ros.timing import AT_ONCE_S, FOUND_S, REPEAT_S, START_S
from hitab_world import (
    LOOK,
    RESTART,
    Action,
    Entity,
    EpisodeResult,
    EpisodicWorld,
    Placement,
    Sensed,
    WorldError,
)
from hitab_world.node.ros_parameters import GivenParameters
from keepaway_world.action import orders_of
from keepaway_world.game.arranging import Place, entities_of, placed, places_of
from keepaway_world.game.rules import KEEPAWAY_RULES, Rules
from keepaway_world.parameters import PAPER, KeepawayParameters

NEW_EPISODE = ("(change_mode drop_ball)", "(change_mode play_on)", "(recover)")
"""Commands by which a trainer begins an episode: the first makes the server forget earlier
kicks."""


def patience_of(node: Node | GivenParameters) -> float:
    """Return how long `RcssWorld.reset` waits for an episode, s; a node calls `idle` instead."""
    return START_S if isinstance(node, GivenParameters) else 0.0


class RcssWorld(EpisodicWorld):
    """A game on an rcssserver, keepaway by default; see `hitab_world.world.LiveWorld`.

    Percepts and actions are those of `keepaway_world.world.KeepawayWorld`. The server plays
    keepaway itself. Other games are matches on the server: the trainer begins each episode, and
    the first stop of play, or our own referee, ends it.

    Args:
        server: address of the server, and the choice of takers.
        parameters: parameters of the game; values that the server decides are taken from it.
        seed: the run's seed, for the agents; the server uses its own seed.
        rules: players, beginning and end of an episode.
        patience: how long `reset` waits for an episode to begin, s; 0 for a node, which calls
            `idle` instead.
    """

    cycle_seconds = 0.1

    def __init__(
        self,
        server: ServerSettings = ServerSettings(),  # noqa: B008  (frozen)
        parameters: KeepawayParameters = PAPER,
        seed: int = 0,
        rules: Rules = KEEPAWAY_RULES,
        *,
        patience: float = 0.0,
    ) -> None:
        self.name, self.looks, self.measures = rules.name, rules.looks, rules.measures
        self.server = server
        self.parameters = parameters
        super().__init__(seed)
        self.waiting = sentences.CONNECTING.format(self.server.where)
        self._given_parameters, self._rules = parameters, rules
        self._patience = patience
        self._link: Link | None = None
        self._trainer: OfflineTrainer | None = None
        self._next_try = 0.0
        self._forget()
        self.agents = self._game.agents

    def _forget(self) -> None:
        """Clear all data about the field."""
        self.size = self.parameters.width, self.parameters.height
        by_sight = self.server.percepts == SEE
        self._game = ReportedGame(self.parameters, self._rules, by_sight=by_sight)
        self._takers = self._rules.takers(self._game.field.physics)
        self._said: dict[str, str] = {}
        self._result: EpisodeResult | None = None
        self._held: dict[str, Place] = {}

    # -- episodes ---------------------------------------------------------------------------

    def reset(self, episode: int | None = None, seed: int | None = None) -> None:
        """Begin the next episode, or restart counting from 0.

        With a trainer, the players are placed as at an episode's beginning. Without a trainer, an
        episode that has already begun must end by itself; until then the world is `waiting`.

        Raises:
            WorldError: for an episode that was played already, or for another seed.
        """
        if seed is not None and seed != self.seed:
            raise WorldError(
                f"an rcssserver uses its own seed (server::random_seed), and this world was "
                f"started with seed {self.seed} for its agents; start it with seed {seed}"
            )
        following = self.episode + 1
        if episode not in (None, 0, self.episode, following) and not self._rules.stops:
            raise WorldError(
                f"an rcssserver cannot repeat or skip to episode {episode}; "
                f"the next one is {following}"
            )
        fresh = (bool(self.ended) or self._game.fresh) and not self._rules.stops
        self.begin_episode(episode, seed)
        self._result = None
        self._held = {}
        if self._link is not None and not self.waiting and not fresh:
            if self._trainer is None:
                self.waiting = sentences.PLAYING_ON.format(self.server.where)
            else:
                self._set_up()
                self._game.begin()
        if self._patience:
            self.wait(self._patience)

    def wait(self, seconds: float) -> None:
        """Keep the server connected until an episode begins.

        Raises:
            WorldError: naming the cause of the delay, if it exceeds the patience.
        """
        deadline = time.monotonic() + seconds
        while self.waiting:
            if time.monotonic() > deadline:
                raise WorldError(self.waiting)
            self.idle()
            time.sleep(0.001)

    def _set_up(self) -> None:
        """Make the trainer place everything as the referee would, drawn from our seed."""
        physics = self._game.field.physics
        self._rules.set_up(physics, Random(world_seed(self.seed, self.episode)))
        self._move(places_of(physics), NEW_EPISODE if self._rules.stops else ())

    def _move(self, places: Mapping[str, Place], before: Iterable[str] = ()) -> None:
        """Make the trainer move things; leave the server if it does not answer.

        Raises:
            WorldError: if the trainer cannot move them.
        """
        assert self._trainer is not None
        try:
            self._trainer.put(places, self._game.field.who, self._rules.center, *before)
        except NoAnswer as error:
            self._leave(str(error))
            raise
        self._game.put(places)

    def result(self) -> EpisodeResult:
        """Return the result of the current episode so far."""
        return self._result or EpisodeResult.of(self, self._game.measures(self.ended))

    # -- cycles -----------------------------------------------------------------------------

    def percept(self, agent: str) -> Sensed:
        """Return a keeper's present percept.

        Raises:
            WorldError: if there is no such keeper.
        """
        if agent not in self.agents:
            raise WorldError(f'no agent "{agent}" (known: {", ".join(self.agents)})')
        return self._game.percept(agent)

    def step(self, actions: Mapping[str, Action]) -> str | None:
        """Play one cycle; return why the episode ended with it, such as "out", else None.

        If the server is lost or stops play, no cycle is played and the world is `waiting`.
        """
        if self.waiting:
            raise WorldError(self.waiting)
        self.refuse_after_end()
        refused: dict[str, str] = {}
        self.refused = refused
        self._held = {}
        self._said = {}
        given = self._takers_commands()
        orders = orders_of(actions, self.agents, self.parameters.say_length, refused)
        for name, order, message in orders:
            given[name] = command_of(order)
            try:
                if message:
                    given[name] += (say(message),)
                    self._said[name] = message
            except ValueError as error:
                refused[name] = f"{name}: {error}"
        self._exchange(given)
        return self.ended or None

    def _takers_commands(self) -> dict[str, tuple[str, ...]]:
        takers = self._game.field.physics.takers if self.server.our_takers else []
        orders = self._takers.decide() if takers else []
        return {taker.name: command_of(order) for taker, order in zip(takers, orders, strict=True)}

    def _exchange(self, given: Mapping[str, tuple[str, ...]]) -> bool:
        """Send commands and receive the next cycle; return whether an episode began with it."""
        assert self._link is not None
        try:
            self._link.poll()  # in real time the server may already have moved on
            self._link.answer(given)
            self._link.await_cycle()
        except ServerError as error:
            late = self._link.joined_late
            self._leave(sentences.JOINED_LATE.format(error) if late else str(error))
            return False
        return self._observe(self._link)

    def _observe(self, link: Link) -> bool:
        """Handle a cycle's messages; return whether an episode began with the cycle."""
        turn = self._game.take(link)
        link.forget()
        self.cycle += turn.passed
        if not self.waiting:
            self.episode_cycle = turn.episode_cycle
            self.ended = turn.ended
            if turn.ended:
                self._result = EpisodeResult.of(self, turn.measures)
        self._update_waiting(turn)
        return turn.began

    def _update_waiting(self, turn: Turn) -> None:
        """Set `waiting` by whether there is an episode to play."""
        missing = "" if turn.state is None else self._game.field.missing(turn.state)
        if self._game.mode == BEFORE_KICK_OFF:
            self.waiting = missing or sentences.BEFORE_PLAY.format(self.server.where)
            now = time.monotonic()
            ready = self.server.kick_off and turn.state is not None and not missing
            if ready and now >= self._next_try:
                self._next_try = now + REPEAT_S
                if self._rules.stops:
                    with contextlib.suppress(WorldError):  # `waiting` then says why
                        self._set_up()
                else:
                    kick_off(self.server.host, self.server.port)
        elif self._game.mode != PLAYING and not self._rules.stops:
            self.waiting = sentences.SERVER_STOPPED.format(self.server.where, self._game.mode)
        elif missing:
            self.waiting = missing
        elif turn.began:
            self.waiting = ""
        elif self.waiting:
            self.waiting = sentences.PLAYING_ON.format(self.server.where)

    # -- a server does not wait -------------------------------------------------------------

    def idle(self) -> str:
        """Keep the server connected; see `hitab_world.world.LiveWorld`."""
        if self._link is None:
            self._join()
            return ""
        if not self.waiting:
            return self._hold()
        deadline = time.monotonic() + AT_ONCE_S
        while self.waiting and self._link is not None and time.monotonic() < deadline:
            self._exchange(self._takers_commands() if self._game.mode == PLAYING else {})
        if self.waiting:
            return ""
        self._result, self.ended, self.episode_cycle = None, "", 0
        return RESTART

    def _hold(self) -> str:
        """Let the server advance as little as possible, and put everything back."""
        link = self._link
        assert link is not None
        self._held = self._held or places_of(self._game.field.physics)
        try:
            link.poll()
        except ServerError as error:
            self._leave(str(error))
            return ""
        if link.synch:
            if time.monotonic() - link.thinking_since < 0.7 * SERVER_WAIT_S:
                return ""
        elif not link.complete:
            return ""
        ended = self.ended
        began = self._exchange({})
        if self._trainer is not None and not self.waiting and not began:
            stopped = self._game.mode != PLAYING
            with contextlib.suppress(WorldError):  # `waiting` then says what the world waits for
                self._move(self._held, NEW_EPISODE if stopped else ())
                self._game.mode = PLAYING
            if not ended:
                self.ended, self._result = "", None
            return ""
        if began:
            self._held = {}
            self._result, self.ended, self.episode_cycle = None, "", 0
        return RESTART if began else LOOK

    def _join(self) -> None:
        """Try to join the server, unless the last attempt was just now."""
        now = time.monotonic()
        if now < self._next_try:
            return
        try:
            if self._rules.stops and not self.server.trainer_port:
                raise ServerError(sentences.NO_TRAINER)
            physics = self._game.field.physics
            names = [m.name for m in physics.keepers], [m.name for m in physics.takers]
            self._link = Link(self.server, names, keepaway=not self._rules.stops)
            self.parameters = parameters_of(
                self._link.settings, self._given_parameters, self._rules
            )
            self._forget()
            if self.server.trainer_port:
                self._trainer = OfflineTrainer(self.server)
            self.waiting = sentences.BEFORE_PLAY.format(self.server.where)
        except ServerError as error:
            self._leave(str(error), REPEAT_S if isinstance(error, NoAnswer) else FOUND_S)

    def _leave(self, why: str, pause: float = REPEAT_S) -> None:
        """Leave the server, to rejoin it when possible."""
        for connection in (self._link, self._trainer):
            if connection is not None:
                connection.close()
        self._link = self._trainer = None
        self._next_try = time.monotonic() + pause
        self.waiting = why

    def close(self) -> None:
        """Take our players out of the game."""
        self._leave("the world has left the server")

    # -- the field ----------------------------------------------------------------------------

    def entities(self) -> list[Entity]:
        """Return the ball and the players as last reported by the server, in SI units."""
        return [*entities_of(self._game.field.physics, self._said), *self._rules.marks]

    def place(self, placements: Iterable[Placement], *, new_episode: bool = False) -> None:
        """Make the trainer put players or the ball somewhere else.

        Raises:
            WorldError: naming what is impossible, or if there is no trainer.
        """
        if self._trainer is None:
            raise WorldError(sentences.NO_TRAINER)
        if self.waiting:
            raise WorldError(self.waiting)
        placements = list(placements)
        places = placed(placements, self._game.field.movers)
        if new_episode:
            self.reset()
            places = placed(placements, self._game.field.movers)
        self._move(places)
        self._held = {}

    def snapshot(self) -> dict[str, Any]:
        """Refuse: an rcssserver's state cannot be read."""
        raise WorldError(sentences.NO_SNAPSHOT)

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Refuse: an rcssserver's state cannot be set."""
        raise WorldError(sentences.NO_SNAPSHOT)
