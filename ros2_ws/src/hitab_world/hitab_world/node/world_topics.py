"""The topics of a world: its state, status, episodes and clock."""

from __future__ import annotations

import time
from typing import Any

from hitab_msgs import msg
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from hitab_ros import GuardedNode, names, qos
from hitab_ros.messages.conversions import message_of, remedy_messages, values_message
from hitab_ros.messages.stamps import NANOSECONDS, time_of
from hitab_world.node.settings import WorldSettings
from hitab_world.simulating.run_state import RunState


class WorldTopics:
    """Publishes the state of a world; the state and the clock only while there are subscribers."""

    def __init__(self, node: GuardedNode, run_state: RunState, settings: WorldSettings) -> None:
        self._guard = node.guard
        self._run_state = run_state
        self._world = run_state.world
        self._settings = settings
        self._note = ""
        self._error = ""
        self._taught = False
        self._next_state_ns = 0
        self._looks = [
            message_of(msg.Look, look, kind=kind) for kind, look in run_state.world.looks.items()
        ]
        self._state = node.create_publisher(msg.WorldState, names.STATE, qos.LATCHED)
        self._status = node.create_publisher(msg.WorldStatus, names.STATUS, qos.LATCHED)
        self._episodes = node.create_publisher(msg.Episode, names.EPISODES, qos.EVENTS)
        self._clock = node.create_publisher(Clock, names.CLOCK, qos.STREAM)

    @property
    def episodes_are_heard(self) -> bool:
        """Whether the episodes have subscribers."""
        return self._episodes.get_subscription_count() > 0

    def publish_clock(self) -> None:
        """Publish the world's time while the clock has subscribers."""
        if self._clock.get_subscription_count():
            self._clock.publish(Clock(clock=self._now()))

    def _now(self) -> Any:
        return time_of(self._world.cycle * self._world.cycle_seconds)

    # -- the status -------------------------------------------------------------------------

    def report_error(self, text: str) -> None:
        """Publish the status with the last error, at most once for the same text."""
        if text != self._error:
            self._error = text
            if text:
                self._guard.log(text)
            self.publish_status()

    def publish_whether_taught(self) -> None:
        """Publish the status if it has changed whether an agent is taught."""
        if bool(self._run_state.round_answers.taught) != self._taught:
            self.publish_status()

    def publish_status(self) -> None:
        """Publish the world's status."""
        world, run_state = self._world, self._run_state
        control, round_answers = run_state.control, run_state.round_answers
        faults = self._guard.faults.texts()
        self._taught = bool(round_answers.taught)
        self._status.publish(
            msg.WorldStatus(
                stamp=self._now(),
                world=world.name,
                mode=self._mode(),
                pace=control.pace,
                factor=control.factor,
                teaching=0.0 if run_state.last_minute is None else control.teaching,
                taught=self._taught,
                held=control.reached,
                oldest=0 if run_state.last_minute is None else run_state.last_minute.oldest,
                cycle=world.cycle,
                episode=world.episode,
                seed=world.seed,
                missed_deadlines=round_answers.missed_deadlines,
                reproducible=self._run_state.reproducible,
                agents=list(world.agents),
                missing=round_answers.missing,
                episodes_left=control.episodes_left,
                last_error=self._error or (faults[0] if faults else ""),
                faults=faults,
                remedies=remedy_messages(self._guard.faults.remedies),
                swarm=self._settings.swarm,
            )
        )

    def _mode(self) -> str:
        at_rest = self._run_state.control.at_rest
        return msg.WorldState.PAUSED if at_rest else msg.WorldState.RUNNING

    # -- episodes ---------------------------------------------------------------------------

    def publish_episode(self, ended: str) -> None:
        """Publish the episode's result, and with the next state why the episode ended."""
        result = self._world.result()
        self._episodes.publish(
            message_of(
                msg.Episode,
                result,
                run=self._run_state.control.run,
                reproducible=self._run_state.reproducible,
                measures=values_message(result.measures.items()),
            )
        )
        self._note = ended

    # -- the state --------------------------------------------------------------------------

    def publish_state_if_due(self, *, at_once: bool) -> None:
        """Publish the true state to viewers at the rate of the settings, or at once."""
        now = time.monotonic_ns()
        if (now >= self._next_state_ns or at_once) and self._state.get_subscription_count():
            self._next_state_ns = now + int(NANOSECONDS / self._settings.state_rate)
            self.publish_state()

    def publish_state(self) -> None:
        """Publish the true state of the world, for viewers."""
        world = self._world
        entities = self._guard.wrap("the state for viewers", self._entities, otherwise=[])()
        self._state.publish(
            msg.WorldState(
                header=Header(stamp=self._now(), frame_id=world.name),
                world=world.name,
                mode=self._mode(),
                cycle=world.cycle,
                episode=world.episode,
                episode_cycle=world.episode_cycle,
                width=float(world.size[0]),
                height=float(world.size[1]),
                entities=entities,
                looks=self._looks,
                change=self._run_state.changes,
                note=self._note,
                swarm=self._settings.swarm,
            )
        )
        self._note = ""

    def _entities(self) -> list[msg.Entity]:
        return [message_of(msg.Entity, entity) for entity in self._world.entities()]
