"""The table of repaired and retrained teams: hold times, and their ratio to retrained ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain
from statistics import fmean, median, stdev
from typing import Any

from scipy.stats import t as student_t

COMPLETE = "complete retraining"
"""The team with which all are compared."""


def ratio(teams: Sequence[Sequence[float]], others: Sequence[Sequence[float]]) -> dict[str, float]:
    """Return the ratio of two means, and the bounds of its 95 % interval.

    The hold times are by person, in pairs. The interval is that of a ratio estimator, once over
    all episodes (`low`, `high`) and once over people (`low_people`, `high_people`), who differ.
    """
    whole = fmean(chain(*others))
    r = fmean(chain(*teams)) / whole
    rests = [
        [x - r * y for x, y in zip(a, b, strict=True)] for a, b in zip(teams, others, strict=True)
    ]
    found = {"ratio": r}
    for key, parts in (("", list(chain(*rests))), ("_people", [fmean(p) for p in rests])):
        half = math.nan
        if len(parts) > 1:
            half = student_t.ppf(0.975, len(parts) - 1) * stdev(parts) / len(parts) ** 0.5 / whole
        found |= {f"low{key}": r - half, f"high{key}": r + half}
    return found


def table(name: str, runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Print what the teams did after a change; return the figures."""
    figures: dict[str, Any] = {}
    people = sorted({run["person"] for run in runs})

    def by_person(team: str, beside: str) -> list[list[float]]:
        played = [run for run in runs if beside in run["seconds"]]
        return [
            [s for run in played if run["person"] == p for s in run["seconds"][team]]
            for p in people
        ]

    print(f"{name}: {len(people)} people")
    for team in runs[0]["seconds"]:
        times, complete = by_person(team, team), by_person(COMPLETE, team)
        every = list(chain(*times))
        learning = list(chain(*(r["learning_ms"].get(team, []) for r in runs if not r["block"])))
        figures[team] = {
            "hold_s": fmean(every),
            "se": stdev(every) / len(every) ** 0.5,
            "people_s": [fmean(t) for t in times],
            "commands": len(learning) / len(people),
            **ratio(times, complete),
        }
        f = figures[team]
        told = f"{f['commands']:4.1f} commands" if learning else ""
        if learning:
            told += f", learned in {median(learning):.1f} ms, at most {max(learning):.1f} ms"
        print(
            f"  {team:44} n {len(every):4d} {f['hold_s']:6.2f} ± {f['se']:.2f} s  "
            f"ratio {f['ratio']:.2f} ({f['low']:.2f} to {f['high']:.2f}; over people "
            f"{f['low_people']:.2f} to {f['high_people']:.2f})  {told}"
        )
    return figures
