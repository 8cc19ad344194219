"""Measures how well an agent estimates how late a person's commands come.

Novices (`novices.py`) whose delays are log-normal around different medians train a team. After
some commands, the agent's estimate of the median is compared with the true one.

    scripts/python research/delays.py --people 12
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from statistics import fmean, stdev
from typing import Annotated

import typer
from novices import NOVICE, Novice
from pupils import InProcessPupil
from rich.console import Console
from rich.table import Table
from teachers import intention_of

from hitab_core.example import Example

MEDIANS = (0.2, 0.4, 0.6, 0.9, 1.2)
"""Of the people's delays, s."""

SPREAD = 0.28
"""Of their logarithm: that of a novice, whose reaction is simple and whose choice varies."""

AFTER = (5, 10, 20)
"""After so many late commands the estimate is read."""


class WatchedPupil(InProcessPupil):
    """A team that notes, after each late command, how late it takes the person to be.

    Attributes:
        estimates: s, one for each late command.
    """

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self.estimates: list[float] = []

    def command(self, state: str, pace: float = 0.0) -> Sequence[Example]:
        """Command the keeper; see `Pupil.command`."""
        taught = super().command(state, pace)
        if pace:
            self.estimates.append(self.lateness)
        return taught


def estimates(number: int, median: float, seed: int) -> list[float]:
    """Return what the agent makes of one person's delay after each late command, s."""
    habits = replace(
        NOVICE, reaction=(0.0, 0.0), choice=(median, SPREAD), patience=0.0, inattention=0.0
    )
    pupil = WatchedPupil(seed * 1000 + number)
    Novice(intention_of(number), habits, seed * 1000 + number).train(pupil)
    pupil.close()
    return pupil.estimates


def main(
    people: Annotated[int, typer.Option(help="How many people of each delay.", min=2)] = 12,
    seed: Annotated[int, typer.Option(help="Of the people.")] = 77,
) -> None:
    """Compare estimates of people's delays with the true ones."""
    table = Table("true median, s", *(f"after {n} commands" for n in AFTER))
    for median in MEDIANS:
        found = [estimates(number, median, seed) for number in range(people)]
        cells = []
        for after in AFTER:
            ratios = [math.log(one[after - 1] / median) for one in found if len(one) >= after]
            cells.append(
                f"x {math.exp(fmean(ratios)):.2f}, spread x {math.exp(stdev(ratios)):.2f} "
                f"({len(ratios)})"
                if len(ratios) > 1
                else "too few"
            )
        table.add_row(f"{median}", *cells)
    Console().print(table)


if __name__ == "__main__":
    typer.run(main)
