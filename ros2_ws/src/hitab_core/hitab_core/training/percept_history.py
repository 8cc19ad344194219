"""Percepts of the agent in training: the latest, and those around each command.

A command is recorded with the situation in which it was due, see
`hitab_core.training.recent_percepts`. The percepts around it are kept, so that the command can be
retimed later; a correction also keeps the corrected decision.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from hitab_core.automaton import FLAGS, OWN_FEATURES, START, as_entered
from hitab_core.domain import Domain
from hitab_core.errors import FeatureValueError
from hitab_core.running.running_automaton import RunningAutomaton
from hitab_core.training.lateness import LateCommand, Lateness
from hitab_core.training.recent_percepts import (
    PerceptRecord,
    RecentPercepts,
    nearest,
    readable,
    state_of,
)
from hitab_core.training.situation_sample import SituationSample
from hitab_core.use import Use

TIMERS = tuple(use for use in OWN_FEATURES if use.name not in FLAGS)
"""Timers are excluded: their reset is not an event in the world."""

BLAMED_SECONDS = 1.0
"""A change of state that was longer before a correction was due is not what is corrected."""


class PerceptHistory:
    """Reads whatever can be read, and keeps it for as long as a command may refer to it.

    Attributes:
        readable: names of the readings.
        moments: the last ones.
        situations: a sample of all, in which questions are looked for.
    """

    def __init__(
        self,
        domain: Domain,
        parameters: Sequence[str],
        chosen: Sequence[Use],
        names: Sequence[Use] = (),
    ) -> None:
        """Keep nothing yet.

        Args:
            domain: of the agent.
            parameters: of the automaton in training.
            chosen: its features.
            names: of the readings; empty for all that can be read. What cannot be read any more is
                NaN.
        """
        found = tuple(names) or readable(domain, parameters)
        self.readable = (*found, *(use for use in chosen if use not in found))
        self.moments = RecentPercepts()
        self.situations = SituationSample()
        self._windows: dict[int, tuple[float, tuple[PerceptRecord, ...]]] = {}
        self._column = {use: i for i, use in enumerate(self.readable)}
        self._discrete = [
            self._column[use]
            for use in chosen
            if use not in TIMERS and not domain.scale_of(use).kind.is_measured
        ]
        self._entered: PerceptRecord | None = None
        self._corrected: set[int] = set()
        self._paces: dict[int, float] = {}

    @property
    def time(self) -> float:
        """The simulated time of the last percept, s; 0 if there was none."""
        latest = self.moments.latest
        return 0.0 if latest is None else latest.time

    @property
    def is_past(self) -> bool:
        """Whether something was perceived that a late command can be meant for."""
        latest, entered = self.moments.latest, self._entered
        return latest is not None and (entered is None or latest.time > entered.time)

    def _read(self, running: RunningAutomaton) -> tuple[float, ...]:
        """Return the readings of now; NaN for what cannot be read."""
        values = map(running.look, self.readable)
        return tuple(value if math.isfinite(value) else math.nan for value in values)

    def keep(
        self, running: RunningAutomaton, cycle: int, time: float, *, jumped: bool = False
    ) -> None:
        """Keep what the agent perceives now, before it acts on that.

        Args:
            running: the performed behavior.
            cycle: of the world.
            time: simulated time, s.
            jumped: whether the situation does not follow from the last one.
        """
        if jumped:
            self.begin()
        moment = PerceptRecord(cycle, time, state_of(running.active), self._read(running))
        self.moments.add(moment)
        self._meet(moment)

    def _meet(self, moment: PerceptRecord) -> None:
        values = (moment.readings[i] for i in self._discrete)
        kind = (moment.state, *(None if math.isnan(value) else value for value in values))
        self.situations.add(kind, moment)

    def remember(self) -> None:
        """Meet again what is kept around commands, after a restart."""
        for _, moments in self._windows.values():
            for moment in moments:
                self._meet(moment)

    def enter(self, label: str, due: PerceptRecord) -> None:
        """Have a commanded state be active since the command was due."""

        def entered(moment: PerceptRecord) -> PerceptRecord:
            seconds = moment.time - due.time
            readings = as_entered(self.readable, moment.readings, seconds)
            return replace(moment, state=label, readings=readings)

        self.moments.enter(due, entered)
        self._entered = entered(due)

    def reenter(self, left: str, state: str) -> None:
        """Have a state be active instead of the one that was entered last, which was undone."""
        self.moments.reenter(left, state)
        self._entered = None

    def begin(self) -> None:
        """Forget earlier percepts, which have no connection with later ones."""
        self.moments = RecentPercepts()
        self._entered = None

    def restart(self, state: str = START) -> None:
        """Forget percepts before the last one, which begins an episode, or another state."""
        latest = self.moments.latest
        self.begin()
        if latest is not None:
            self.situations.forget_from(latest.time)
            readings = as_entered(self.readable, latest.readings)
            begun = replace(latest, state=state_of(state), readings=readings)
            self.moments.add(begun)
            self._meet(begun)

    def due(
        self,
        running: RunningAutomaton,
        features: Sequence[Use],
        cycle: int,
        ago: float,
        seen: int,
    ) -> PerceptRecord:
        """Return the moment for which a command is meant.

        Args:
            running: what the agent performs.
            features: of the automaton in training.
            cycle: of the world, now.
            ago, seen: see `RecentPercepts.due`.

        Raises:
            TrainingError: if that moment is not kept.
            FeatureValueError: as reading the features.
        """
        latest = self.moments.latest
        if ago or seen:
            due = self.moments.due(ago, seen)
            entered = self._entered
            if entered is not None and due.time <= entered.time:
                due = entered  # no command was due before the one that the person gave before it
            if not self.shows(due, features):  # nothing was sensed for a moment
                near = [m for m in self._since_entered() if abs(m.time - due.time) <= ago]
                shown = [m for m in near if self.shows(m, features)]
                due = nearest(shown, due.time) if shown else due
            if latest is not None and due.time < latest.time:
                return due
        # The present one, with the values that the next decision would use.
        values = running.peek_features()
        readings = list(self._read(running))
        for feature, value in zip(features, values, strict=True):
            readings[self._column[feature]] = value
        return PerceptRecord(cycle, self.time, state_of(running.active), tuple(readings))

    def _since_entered(self) -> Sequence[PerceptRecord]:
        """Return the moments for which a command can be meant, after that of the one before it."""
        entered, kept = self._entered, self.moments.since(-math.inf)
        if entered is None:
            return kept
        return (entered, *(moment for moment in kept if moment.time > entered.time))

    def in_moment(self, moment: PerceptRecord, features: Sequence[Use]) -> tuple[float, ...]:
        """Return the values of features in a moment; NaN where there is none."""
        return tuple(moment.readings[self._column[feature]] for feature in features)

    def shows(self, moment: PerceptRecord, features: Sequence[Use]) -> bool:
        """Return whether there can be an example of a moment: one of some features has a value."""
        values = self.in_moment(moment, features)
        return not values or not all(map(math.isnan, values))

    def values(self, moment: PerceptRecord, features: Sequence[Use]) -> tuple[float, ...]:
        """Return the values of features in a moment.

        Raises:
            FeatureValueError: if none has one, or one is infinite.
        """
        values = self.in_moment(moment, features)
        for feature, value in zip(features, values, strict=True):
            if math.isinf(value):
                raise FeatureValueError(
                    f'feature "{feature}" is {value} but must be finite in an example; have it '
                    "return a large number instead, such as the range of its sensor"
                )
        if not self.shows(moment, features):
            raise FeatureValueError(
                f"no feature of this training has a value now ({', '.join(map(str, features))}); "
                "check the sensors, or choose other features"
            )
        return values

    # -- moments that stay with the examples ------------------------------------------------

    def around(
        self, due: PerceptRecord, taken_over_in: str = "", commanded: str = "", pace: float = 0.0
    ) -> dict[str, Any]:
        """Return what to keep with a command, as plain data for the journal.

        Args:
            due: the moment at which the command was due.
            taken_over_in: label of the state that the automaton was in when the person took over
                to give this command; empty if the automaton had not decided.
            commanded: label of the state that was commanded.
            pace: simulated seconds per second of a person with an unknown delay; 0 if the
                moment is known.
        """
        record: dict[str, Any] = {
            "time": self.time,
            "moments": [m.to_record() for m in self.moments.window(due)],
        }
        if pace:
            record["pace"] = pace
        if taken_over_in and self._wrong_decision(due, taken_over_in) != commanded:
            record["corrects"] = True
        return record

    def keep_around(self, command: int, record: Mapping[str, Any]) -> None:
        """Keep what `around` returned for the command of this number."""
        if "pace" in record:
            self._paces[command] = float(record["pace"])
        moments = tuple(map(PerceptRecord.from_record, record.get("moments", ())))
        if moments:
            self._windows[command] = (float(record["time"]), moments)
        if "corrects" in record:
            self._corrected.add(command)

    def _wrong_decision(self, due: PerceptRecord, active: str) -> str:
        """Return the state to which the decision led that a person corrects.

        It is the first change of state after the command was due, whatever followed before the
        person took over; else the last one before, if that was not long before; else that the
        automaton stayed in the state that was active then.

        Args:
            due: the moment at which the command was due.
            active: label of the state that the automaton was in when the person took over.
        """
        kept = self.moments.since(due.time - BLAMED_SECONDS)
        states = [*(moment.state for moment in kept), active]
        changes = [
            (moment, after)
            for moment, after in zip(kept, states[1:], strict=True)
            if moment.state != after
        ]
        for moment, after in changes:
            if moment.time >= due.time:
                return after
        return changes[-1][1] if changes else due.state

    def late(
        self,
        command: int,
        label: str,
        features: Sequence[Use],
        lateness: Lateness,
        recorded: tuple[str, int] | None = None,
    ) -> tuple[LateCommand, Sequence[PerceptRecord]] | None:
        """Return a command that came late, and the moments for which it may have been meant.

        Args:
            command: its number.
            label: of the next state.
            features: of the automaton in training.
            lateness: of the person.
            recorded: the state and the cycle for which it was recorded; None before that.

        Returns:
            The command; and the moments in one state, with one in which the automaton changed its
            state last, if it may correct that. None if it is known when the command was due.
        """
        pace = self._paces.get(command)
        if pace is None or command not in self._windows:
            return None
        given, moments = self._windows[command]
        delays = (given - np.array([moment.time for moment in moments])) / pace
        odds = lateness.density(delays)
        states = [moment.state for moment in moments]
        ends = [i for i in range(len(states) - 1) if states[i] != states[i + 1]]
        stretches = list(pairwise([0, *(end + 1 for end in ends), len(states)]))
        changed: int | None = None
        if command in self._corrected:
            wrong = [end for end in ends if states[end + 1] != label]
            changed = max(wrong, key=lambda end: odds[end], default=None)
        else:
            stretches = stretches[-1:]
        corrects = None
        begin, end = max(stretches, key=lambda one: odds[one[0] : one[1]].sum())
        if recorded is not None:
            there = [i for i, m in enumerate(moments) if (m.state, m.cycle) == recorded]
            corrects = None if changed is None else there == [changed]
            if there and not corrects:
                begin, end = next(one for one in stretches if one[1] > there[0])
        if states[begin] == label and changed is None:
            return None
        among = moments[begin:end]
        values = np.array([self.in_moment(one, features) for one in among])
        values = values.reshape(len(among), len(features))
        late = LateCommand(states[begin], label, delays[begin:end], values)
        if changed is None:
            return late, among
        late = replace(late, changed=float(delays[changed]), corrects=corrects)
        return late, (*among, moments[changed])

    def window(self, command: int) -> tuple[float, tuple[PerceptRecord, ...]] | None:
        """Return when a command was given, s, and the moments that are kept around it."""
        return self._windows.get(command)
