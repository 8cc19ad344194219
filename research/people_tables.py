"""The tables of simulated people: how many succeed, and what was learned otherwise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import NormalDist, fmean, stdev
from typing import Any

OBJECTION = 0.1
"""A kind of decision counts as learned otherwise if more than this part of it was not intended."""


OFF = 0.15
"""A command is recorded off that is recorded more than this from when it was due, s."""

BIN = 10
"""Commands in one step of a curve."""


def by_chance(own: float, spread: float, needed: float, episodes: int, own_episodes: int) -> float:
    """Return how probably a team fails that plays as well as the intention.

    Args:
        own, spread: mean and standard deviation of the intention's hold times, s.
        needed: what the team has to reach, s; mostly a part of ``own``.
        episodes, own_episodes: that the team and the intention play.
    """
    part = needed / own
    error = spread * (1.0 / episodes + part**2 / own_episodes) ** 0.5
    return NormalDist(own, error).cdf(needed) if error else float(own < needed)


def curve(people: Sequence[Mapping[str, Any]]) -> list[dict[str, float]]:
    """Return how many succeed, and the part of the own hold time, by commands given."""
    steps: dict[int, list[Mapping[str, Any]]] = {}
    for p in people:
        steps.setdefault(p.get("counts", {}).get("commands", 0) // BIN, []).append(p)
    return [
        {
            "commands": BIN * step,
            "people": len(those),
            "succeed": sum(p["success"] for p in those),
            "of_own": fmean(p["hold_s"] / p["own_s"] for p in those),
        }
        for step, those in sorted(steps.items())
    ]


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
    off = [one for p in people for one in p.get("off", ())]
    wrong = sum(abs(seconds) > OFF for seconds, _ in off) / max(1, len(off))
    other = sum(there for _, there in off) / max(1, len(off))
    low, high = interval(good, len(people))
    return (
        f"{title:48} {good:3}/{len(people):<3} ({low:.0%} to {high:.0%})  "
        f"hold {fmean(p['hold_s'] for p in people):5.1f} s  "
        f"own {fmean(p['own_s'] for p in people):5.1f} s  "
        f"of own {fmean(ratio):.2f} ± {spread:.2f}  "
        f"examples {fmean(p['held'] for p in people):4.1f} "
        f"of {fmean(p['given'] for p in people):4.1f}  "
        f"commands {counts['commands'] / len(people):4.1f}  "
        f"off {wrong:.0%}  in another state {other:.0%}  "
        f"equal teams that fail by chance {sum(p.get('by_chance', 0.0) for p in people):.1f}"
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
