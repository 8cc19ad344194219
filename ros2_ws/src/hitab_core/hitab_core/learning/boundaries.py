"""Placement of a boundary between two neighboring examples, on a line and on a circle.

It lies half-way between them, with one exception. Between a default example and a demonstrated one
it lies immediately beside the demonstrated one, at the next representable number on the default's
side, so that the behavior is kept everywhere else (paper, section 3, footnote 1).

On a line, a demonstration holds for all values farther from the default example, too. On a circle
it would hold for its own value only, which hardly ever occurs again, since the default example
would reach it from the other side as well. So a demonstration within a quarter of the circle from
the default example holds for that side of the circle: a command to turn left for a ball 20 degrees
to the left, among default examples for a ball straight ahead, means 20 to 160 degrees. The default
example reaches to the place opposite to it and as far past that as it reaches towards the
demonstration. Default examples that lie farther away, or on both sides, leave only what was
demonstrated.

Several examples may share a value: a value is default here if all its examples are. So a boundary
is placed beside a value only if some example there is not default and every example at the
neighboring value is.
"""

from __future__ import annotations

import math


def threshold_between(
    below: float, above: float, *, below_is_default: bool = False, above_is_default: bool = False
) -> float:
    """Return a threshold ``t`` with ``below <= t < above``, for the test ``value <= t``.

    This holds for all finite values, even adjacent ones or ones whose sum overflows.

    Args:
        below, above: two finite values, ``below < above``.
        below_is_default, above_is_default: whether all examples at that value are default ones.
    """
    if below_is_default == above_is_default:
        middle = (below + above) / 2
        if not math.isfinite(middle):
            middle = below / 2 + above / 2
        threshold = middle if below <= middle < above else below
    elif above_is_default:
        beside = math.nextafter(below, math.inf)
        threshold = beside if beside < above else below
    else:
        threshold = math.nextafter(above, -math.inf)
    return threshold + 0.0  # no negative zero, which would print and digest differently


def end_between(
    before: float,
    after: float,
    period: float,
    *,
    before_is_default: bool = False,
    after_is_default: bool = False,
    kept: float = math.inf,
) -> float:
    """Return an end of an arc, in ``(before, after]`` on the circle.

    A value at the end or after it lies on the side of ``after``.

    Args:
        before, after: two different values in [0, period); ``after`` is the next one upwards,
            which may lead through zero.
        period: the length of the circle.
        before_is_default, after_is_default: whether all examples at that value are default ones.
        kept: distance the other way from the default example, across all of its side, to the
            nearest demonstrated one; infinite: the default example reaches all around the circle.
    """
    if before_is_default == after_is_default:
        gap = after - before if before < after else after - before + period
        end = before + gap / 2
        if end >= period:
            end -= period
    elif after_is_default:
        end = math.nextafter(before, math.inf)
        if end >= period:
            end = 0.0
    else:
        end = math.nextafter(after if after > 0 else period, 0.0)
    reach, gap = period / 2 + kept, (after - before) % period
    if before_is_default != after_is_default and reach < gap:
        on_this_side = on_circle(before + reach if before_is_default else after - reach, period)
        if 0 < (on_this_side - before) % period < gap:  # not rounded away
            end = on_this_side
    reached = end <= after
    apart = (before < end and reached) if before < after else (before < end or reached)
    return end if apart else after


def on_circle(value: float, period: float) -> float:
    """Return the place of ``value`` in [0, period); NaN if it is missing.

    Python's remainder of a tiny negative number is ``period`` itself, the same place as zero.
    """
    place = value % period
    return 0.0 if place >= period else place
