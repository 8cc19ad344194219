"""A history of percepts: of the last seconds, and around each command.

A person needs time to react, so the situation that a command is meant for is already past when the
command arrives. A command that says how long ago it was due is recorded with the situation of that
time. The percepts around it are kept, so that the command can be retimed later.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import repeat
from typing import Any

from hitab_core.automaton import as_entered
from hitab_core.codec import from_dict, to_dict
from hitab_core.domain import Domain
from hitab_core.running.running_automaton import RunningAutomaton
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, TrainingError
from hitab_core.training.events import Given
from hitab_core.training.past import Past
from hitab_core.training.percepts import PerceptRecord, nearest, readable, state_of

KEPT_SECONDS = 10.0
"""Simulated time in which a command may be late; for older percepts see `past`."""

WINDOW_SECONDS = 2.0
"""Minimum time before its command for which percepts stay with an example."""

WINDOW_MAX = 50
"""The most moments that stay with an example."""

STEP_SECONDS = 0.02
"""Moments that follow each other faster are not all kept."""


class PerceptHistory:
    """Reads all readable features, and keeps the percepts to which a command may refer.

    It never reaches back beyond a jump: a new episode, or a change of a paused world.

    Attributes:
        readable: names of the readings.
        past: the percepts of the last minute as they were, for exact commands.
    """

    def __init__(
        self,
        domain: Domain,
        parameters: Sequence[str],
        chosen: Sequence[Term],
        names: Sequence[Term] = (),
    ) -> None:
        """Keep nothing yet.

        Args:
            domain: domain of the agent.
            parameters: parameters of the automaton in training.
            chosen: features of the automaton in training.
            names: names of the readings; empty for all readable features. Features that are no
                longer readable are NaN.
        """
        found = tuple(names) or readable(domain, parameters)
        self.readable = (*found, *(term for term in chosen if term not in found))
        self.past = Past()
        self._kept: list[PerceptRecord] = []
        self._windows: dict[int, tuple[float, tuple[PerceptRecord, ...]]] = {}
        self._column = {term: i for i, term in enumerate(self.readable)}
        self._entered: PerceptRecord | None = None

    @property
    def latest(self) -> PerceptRecord | None:
        """The last percept; None if there is none."""
        return self._kept[-1] if self._kept else None

    @property
    def time(self) -> float:
        """The simulated time of the last percept, s; 0 if there was none."""
        return self._kept[-1].time if self._kept else 0.0

    def is_gone(self, given: Given) -> bool:
        """Whether a command is exact and for a percept before the last one."""
        return given.exact and bool(self._kept) and 0 < given.seen < self._kept[-1].cycle

    def is_past(self, seen: int = 0) -> bool:
        """Return whether a late command of somebody who saw a cycle can have been due before."""
        entered = self._entered
        return bool(self._kept) and (entered is None or self.at(0.0, seen).time > entered.time)

    def _read(self, running: RunningAutomaton) -> tuple[float, ...]:
        """Return the present readings; NaN if one cannot be read."""
        values = map(running.vector.look, self.readable, repeat(running.child))
        return tuple(value if math.isfinite(value) else math.nan for value in values)

    def keep(
        self, running: RunningAutomaton, cycle: int, time: float, *, jumped: bool = False
    ) -> PerceptRecord:
        """Keep and return the present percept, before the agent acts on it.

        Args:
            running: the performed behavior.
            cycle: the world's cycle.
            time: simulated time, s.
            jumped: whether the situation does not follow from the last one.
        """
        if jumped:
            self.begin()
        moment = PerceptRecord(cycle, time, state_of(running.active), self._read(running))
        self._add(moment)
        return moment

    def _add(self, moment: PerceptRecord) -> None:
        """Keep a moment, unless it follows the last but one too fast; drop those too old."""
        kept = self._kept
        if kept and moment.time < kept[-1].time:
            kept.clear()  # the world's clock was set back
        if len(kept) > 1 and kept[-1].time - kept[-2].time < STEP_SECONDS:
            kept.pop()
        self.past.add(moment, STEP_SECONDS)
        kept.append(moment)
        if moment.time - kept[0].time > KEPT_SECONDS:
            first = bisect_right(kept, moment.time - KEPT_SECONDS, key=lambda m: m.time)
            del kept[:first]

    def enter(self, label: str, due: PerceptRecord) -> None:
        """Change the percepts since a command was due to the commanded state."""

        def entered(moment: PerceptRecord) -> PerceptRecord:
            seconds = moment.time - due.time
            readings = as_entered(self.readable, moment.readings, seconds)
            return replace(moment, state=label, readings=readings)

        self.past.intervene(due.time)
        self._kept = [entered(m) if m.time > due.time else m for m in self._kept]
        self._entered = entered(due)

    def reenter(self, left: str, state: str) -> None:
        """Change the percepts in the state of an undone command to the state before it."""
        for place in range(len(self._kept) - 1, -1, -1):
            if self._kept[place].state != left:
                break
            self._kept[place] = replace(self._kept[place], state=state)
        self._entered = None

    def intervened(self, state: str) -> None:
        """Note that somebody intervened in a state, which commands for the past do not undo."""
        self.past.intervene(self.time)

    def begin(self) -> None:
        """Forget earlier percepts, which have no connection with later ones."""
        self._kept = []
        self._entered = None
        self.past.forget()

    def back(self, cycle: int) -> None:
        """Forget the percepts from a cycle on, since the world went back to it."""
        self.past.back(cycle)
        self._kept = [m for m in self._kept if m.cycle < cycle]
        self._entered = None

    def restart(self, state: str) -> PerceptRecord | None:
        """Forget percepts before the last one, which begins an episode, or another state.

        Returns:
            The last one, in this state; None if there is none.
        """
        latest = self.latest
        self.begin()
        if latest is None:
            return None
        readings = as_entered(self.readable, latest.readings)
        begun = replace(latest, state=state_of(state), readings=readings)
        self._add(begun)
        return begun

    def due(
        self,
        running: RunningAutomaton,
        features: Sequence[Term],
        given: Given,
    ) -> PerceptRecord:
        """Return the moment at which a command was due; an exact one for the past, see `past`.

        Args:
            running: the performed behavior.
            features: features of the automaton in training.
            given: the world's cycles, now and as the demonstrator saw it.

        Raises:
            TrainingError: if that moment is not kept.
            FeatureValueError: see `FeatureVector.read`.
        """
        if self.is_gone(given):
            return self.past.at(given.seen)
        if given.seen:
            due = self.at(0.0, given.seen)
            entered = self._entered
            if entered is not None and due.time <= entered.time:
                due = entered  # no command was due before the person's previous command
            if due.time < self.time:
                return due
        # The present one, with the values that the next decision would use.
        values = running.vector.peek(running.child)
        readings = list(self._read(running))
        for feature, value in zip(features, values, strict=True):
            readings[self._column[feature]] = value
        return PerceptRecord(given.cycle, self.time, state_of(running.active), tuple(readings))

    def at(self, ago: float, seen: int = 0) -> PerceptRecord:
        """Return the moment nearest to when a command was due.

        Args:
            ago: time from when it was due to what the demonstrator saw, s of simulated time.
            seen: the world's cycle that the demonstrator saw; 0 for the last one.

        Raises:
            TrainingError: if that is in the future, or longer ago than is kept.
        """
        if not 0.0 <= ago <= KEPT_SECONDS:
            raise TrainingError(
                f"a command cannot have been due {ago:g} s ago: the agent keeps the last "
                f"{KEPT_SECONDS:g} s; give a number from 0 to {KEPT_SECONDS:g}"
            )
        kept, base = self._kept, self.time
        if not kept:
            raise TrainingError(
                f"nothing was perceived {ago:g} s ago; command without saying when it was due"
            )
        if seen and seen < kept[0].cycle and base - kept[0].time > KEPT_SECONDS / 2:
            raise TrainingError(
                f"cycle {seen} was more than {KEPT_SECONDS:g} s ago, and the agent keeps only "
                f"the last {KEPT_SECONDS:g} s; command on what the world shows now"
            )
        if seen:
            base = next((m.time for m in reversed(kept) if m.cycle <= seen), kept[0].time)
        return nearest(kept, base - ago)

    def since(self, time: float) -> list[PerceptRecord]:
        """Return the moments from a time on, s."""
        return [moment for moment in self._kept if moment.time >= time]

    def following(self, cycle: int, seconds: float) -> Sequence[PerceptRecord]:
        """Return the moments from a cycle on, for some time; empty if that is no longer kept."""
        for moments in (self._kept, *(window for _, window in self._windows.values())):
            place = next((i for i, moment in enumerate(moments) if moment.cycle == cycle), None)
            if place is not None:
                until = moments[place].time + seconds
                return [moment for moment in moments[place:] if moment.time <= until]
        return ()

    def in_moment(self, moment: PerceptRecord, features: Sequence[Term]) -> tuple[float, ...]:
        """Return the values of features in a moment; NaN where there is none."""
        return tuple(moment.readings[self._column[feature]] for feature in features)

    def shows(self, moment: PerceptRecord, features: Sequence[Term]) -> bool:
        """Return whether there can be an example of a moment: some feature has a value."""
        values = self.in_moment(moment, features)
        return not values or not all(map(math.isnan, values))

    def values(self, moment: PerceptRecord, features: Sequence[Term]) -> tuple[float, ...]:
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

    def window(self, due: PerceptRecord) -> tuple[PerceptRecord, ...]:
        """Return the percepts to keep with an example, for retiming the example later."""
        start = min(due.time - WINDOW_SECONDS / 2, self.time - WINDOW_SECONDS)
        chosen = self.since(start)
        step = -(-len(chosen) // WINDOW_MAX) or 1
        return tuple(m for i, m in enumerate(reversed(chosen)) if i % step == 0)[::-1]

    def around(self, due: PerceptRecord, given: Given) -> dict[str, Any]:
        """Return the journal's fields for the percepts around a command.

        Args:
            due: the percept for which it was due.
            given: the circumstances; if it is for the past, the fields are those of that time,
                ``as_of``, and ``stays`` if the agent continues with what it does.
        """
        if not self.is_gone(given):
            return {"time": self.time, "moments": list(map(to_dict, self.window(due)))}
        moments = self.past.before(due, WINDOW_SECONDS)
        step = -(-len(moments) // WINDOW_MAX) or 1
        found = {"time": self.time, "moments": list(map(to_dict, moments[::-step][::-1]))}
        stays = {"stays": True} if self.past.intervened > due.time else {}
        return {**found, "as_of": due.time, **stays}

    def keep_around(self, record: Mapping[str, Any]) -> None:
        """Keep the percepts around a command, from its record in the journal."""
        moments = tuple(from_dict(PerceptRecord, m) for m in record.get("moments", ()))
        if moments:
            command = int(record["examples"][0]["command"])
            time = float(record.get("as_of", record["time"]))
            self._windows[command] = (time, moments)

    def kept(self) -> Iterator[PerceptRecord]:
        """Iterate over the percepts kept around all commands."""
        return (moment for _, moments in self._windows.values() for moment in moments)

    def kept_around(self, command: int) -> tuple[float, tuple[PerceptRecord, ...]] | None:
        """Return the time of a command, s, and the moments kept around it."""
        return self._windows.get(command)
