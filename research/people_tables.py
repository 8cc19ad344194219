"""The tables of simulated people: how many succeed, and what was learned otherwise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import fmean, stdev
from typing import Any

OBJECTION = 0.1
"""A kind of decision counts as learned otherwise if more than this part of it was not intended."""


def interval(good: int, of: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a fraction that was counted.

    Reference: E. B. Wilson, Probable inference, Journal of the American Statistical Association
    22, 1927.
    """
    z = 1.96
    middle = (good + z * z / 2) / (of + z * z)
    half = z * (good * (of - good) / of + z * z / 4) ** 0.5 / (of + z * z)
    return max(0.0, middle - half), min(1.0, middle + half)


def row(title: str, people: Sequence[Mapping[str, Any]]) -> str:
    """Return one line of a table."""
    if not people:
        return f"{title:48} nobody"
    counts: Counter[str] = Counter()
    for p in people:
        counts.update(p.get("counts", {}))
    ratio = [p["hold_s"] / p["own_s"] for p in people]
    spread = stdev(ratio) / len(ratio) ** 0.5 if len(ratio) > 1 else 0.0
    good = sum(p["success"] for p in people)
    low, high = interval(good, len(people))
    return (
        f"{title:48} {good:3}/{len(people):<3} ({low:.0%} to {high:.0%})  "
        f"hold {fmean(p['hold_s'] for p in people):5.1f} s  "
        f"own {fmean(p['own_s'] for p in people):5.1f} s  "
        f"of own {fmean(ratio):.2f} ± {spread:.2f}  "
        f"examples {fmean(p['held'] for p in people):4.1f} "
        f"of {fmean(p['given'] for p in people):4.1f}  "
        f"commands {counts['commands'] / len(people):4.1f}"
    )


def diagnosis(people: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return lines on the decisions that were learned otherwise than intended, the worst first."""
    failed: Counter[str] = Counter()
    good: Counter[str] = Counter()
    for figures in people:
        kinds = [k for k, share in figures.get("objections", {}).items() if share > OBJECTION]
        (good if figures["success"] else failed).update(kinds)
    lines = [f"    {'decision learned otherwise':44} failed  succeeded"]
    for kind in sorted(failed + good, key=lambda kind: -(failed + good)[kind])[:16]:
        lines.append(f"    {kind:44} {failed[kind]:6} {good[kind]:10}")
    return lines
