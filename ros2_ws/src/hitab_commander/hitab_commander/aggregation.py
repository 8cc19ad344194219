"""Aggregates over a group, from what each member reports; pure functions.

Members that are silent or have no value for a feature are left out. Over no members, no question
is true, and a mean, a minimum or a maximum has no value (NaN).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from statistics import fmean

from hitab_commander.kind import Observation, Over
from hitab_core.orders import OrderId, Report

NAN = math.nan


def observed(report: Report, of: Observation, asked: Sequence[str], order: OrderId) -> float:
    """Return what is observed in one member: a value, or 1 or 0 for true or false.

    Args:
        report: the member's last report.
        of: the observation.
        asked: names of the report's values.
        order: the order in force. Flags belong to the order under which they were raised, values
            to the epoch in which they were requested.

    Returns:
        NaN if the member has no such value.
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
    """Whether a state has this name, with or without its targets."""
    return label == name or (label.startswith(name) and label[len(name)] == "(")


def summed_up(values: Iterable[float], over: Over) -> float:
    """Return an aggregate of what was observed in the members of a group."""
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

    NaN: no position is known.
    """
    known = [position for position in positions if len(position) == 2]
    if not known:
        return NAN
    x, y = (fmean(values) for values in zip(*known, strict=True))
    if part in "xy":
        return x if part == "x" else y
    return math.sqrt(fmean((p[0] - x) ** 2 + (p[1] - y) ** 2 for p in known))
