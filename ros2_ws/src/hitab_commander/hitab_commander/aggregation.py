"""Aggregates of the reports of a group's members; pure functions.

Callers leave out silent members, and the functions leave out members without a value. Over no
members, `Over.ANY` and `Over.ALL` are false, counts and fractions are 0, and means, minima and
maxima have no value (NaN).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from statistics import fmean

from hitab_commander.kinds.kind import Observation, Over
from hitab_core.orders import OrderId, Report

NAN = math.nan


def observed(report: Report, of: Observation, asked: Sequence[str], order: OrderId) -> float:
    """Return an observation of one member: a value, or 1 or 0 for true or false.

    Args:
        report: the member's last report.
        of: the observation.
        asked: names of the report's values, in their order.
        order: the order in force. A flag counts only under the order under which it was raised,
            and a value only in the epoch in which it was requested.

    Returns:
        The observation; NaN if the member has no such value.
    """
    if of.flag:
        return float(of.flag in report.flags and (report.epoch, report.sequence) == order)
    if of.active:
        return float(any(_is_called(label, of.active) for label in report.path))
    if report.epoch != order[0]:
        return NAN
    index = asked.index(of.feature)
    value = report.values[index] if index < len(report.values) else NAN
    if math.isnan(value) or not of.is_question:
        return value
    above = of.above is None or value > of.above
    return float(above and (of.below is None or value < of.below))


def _is_called(label: str, name: str) -> bool:
    """Whether a state's label has this name, with or without targets."""
    return label == name or (label.startswith(name) and label[len(name)] == "(")


def summed_up(values: Iterable[float], over: Over) -> float:
    """Return the aggregate of an observation of a group's members; NaN values are left out."""
    known = [value for value in values if not math.isnan(value)]
    match over:
        case Over.ANY:
            return float(any(known))
        case Over.ALL:
            return float(bool(known) and all(known))
        case Over.COUNT:
            return float(sum(value != 0.0 for value in known))
        case Over.FRACTION:
            return sum(value != 0.0 for value in known) / len(known) if known else 0.0
        case Over.MEAN:
            return fmean(known) if known else NAN
        case Over.MINIMUM:
            return min(known, default=NAN)
        case Over.MAXIMUM:
            return max(known, default=NAN)
    raise ValueError(f"{over} does not aggregate over all members")


def of_positions(part: str, positions: Iterable[Sequence[float]]) -> float:
    """Return the mean x or y, or the root mean square of the distances from the mean, m.

    The result is NaN if no position is known.
    """
    known = [position for position in positions if len(position) == 2]
    if not known:
        return NAN
    x, y = (fmean(values) for values in zip(*known, strict=True))
    if part in "xy":
        return x if part == "x" else y
    return math.sqrt(fmean((p[0] - x) ** 2 + (p[1] - y) ** 2 for p in known))
