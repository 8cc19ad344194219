"""What a person responded to: the moment for which a late command was meant.

A reaction time is known only roughly, and a moment too early is worse than one too late: the
example then says to change state although nothing has happened yet. People respond to events. So
a command is recorded with the first event that lies as long ago as it was due, give or take what a
person's reaction times vary by:

- a boolean feature or a flag, or a categorical feature, changed, or a feature got or lost a value;
- a continuous or toroidal value jumped: one step was several times as long as any other step
  around that time;
- before a correction: the automaton changed state, and not to what is commanded. The command is
  then meant for the decision that it contradicts.

Who corrects a robot that goes on has waited for it to do something else. So if there was no event
at that time, a correction is recorded with the last one before, up to as long before.

If there was no event, the nearest moment counts.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence

from hitab_core.domain import FeatureKind, Scale
from hitab_core.training.moments import Moment, nearest

SPREAD = 1.0 / 3.0
"""By which part of itself a person's reaction time varies, in either direction; about two standard
deviations of simple reaction times."""

JUMP = 4.0
"""A value jumps in a step that is longer than any other one around it by this factor."""

STILL = 1e-9
"""A shorter step, relative to the value, is the rounding of a value that rests."""

OTHERS_MIN = 2
"""With fewer other steps nobody can tell a jump from a movement."""

AROUND = 3
"""A step is compared with at least so many before and after it, as far as they are known."""


def responded(
    moments: Sequence[Moment],
    due: Moment,
    ago: float,
    columns: Mapping[int, Scale],
    corrects: str = "",
) -> Moment:
    """Return the moment that a command responded to.

    Args:
        moments: oldest first. The first one was responded to before, by the command that was due
            then; or it is there twice, since nothing is known of what was before.
        due: one of them, nearest to the time at which the command was due.
        ago: how long ago that was, as far as known, s.
        columns: the scales of the readings that count, by column.
        corrects: label of the commanded state, if the command corrects an automaton that decided
            by itself; else empty.
    """
    times = [moment.time for moment in moments]
    readings = [([m.readings[column] for m in moments], s) for column, s in columns.items()]
    states = [moment.state for moment in moments]

    def place_of(time: float) -> int:
        return max(1, bisect_left(times, nearest(moments, time).time))

    def event(first: int, last: int) -> int | None:
        places = [_event(values, scale, first, last) for values, scale in readings]
        if corrects:
            places.append(_contradicted(states, corrects, first, last))
        return min((place for place in places if place is not None), default=None)

    first = place_of(due.time - SPREAD * ago)
    place = event(first, bisect_left(times, nearest(moments, due.time + SPREAD * ago).time))
    if place is None and corrects:
        waited = place_of(due.time - ago)
        before = (event(earlier, earlier) for earlier in range(first - 1, waited - 1, -1))
        place = next((found for found in before if found is not None), None)
    return due if place is None else moments[place]


def _contradicted(states: Sequence[str], commanded: str, first: int, last: int) -> int | None:
    """Return the first place from ``first`` to ``last`` at which a change of state was decided."""
    for place in range(first, min(last + 1, len(states) - 1)):
        if states[place + 1] not in (states[place], commanded):
            return place
    return None


def _event(values: Sequence[float], scale: Scale, first: int, last: int) -> int | None:
    """Return the first place from ``first`` to ``last`` in which something happened to a value."""
    compares = scale.kind.is_measured
    for place in range(first, last + 1):
        missing = math.isnan(values[place])
        if missing != math.isnan(values[place - 1]):
            return place
        if missing or compares or values[place] == values[place - 1]:
            continue
        if place > 1 and values[place - 2] == values[place]:
            return place - 1  # it was so for one moment only, and that is what there was to see
        return place
    return _jump(values, scale, first, last) if compares else None


def _jump(values: Sequence[float], scale: Scale, first: int, last: int) -> int | None:
    """Return the place to which a value jumped, if it did.

    It is compared with the steps to the places from ``first`` to ``last``, and as many before and
    after.
    """
    if last < first:
        return None
    width = max(AROUND, last - first + 1)
    around = range(max(1, first - width), min(len(values), last + 1 + width))
    steps = {place: _step(values[place - 1], values[place], scale) for place in around}
    longest = max(steps, key=steps.__getitem__)
    others = [step for place, step in steps.items() if place != longest]
    if not first <= longest <= last or len(others) < OTHERS_MIN:
        return None
    rest = STILL * max(1.0, abs(values[longest]))
    return longest if steps[longest] > max(rest, JUMP * max(others)) else None


def _step(before: float, after: float, scale: Scale) -> float:
    """Return how far apart two values are; 0 where one is missing."""
    step = after - before
    if math.isnan(step):
        return 0.0
    if scale.kind is FeatureKind.TOROIDAL:
        step = math.remainder(step, scale.period)
    return abs(step)
