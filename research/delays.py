"""Measures how well an agent estimates how late a person's commands come.

Novices (`novices.py`) who are in time, early, or late by about some time (log-normally) train a
team. After some commands, the agent's estimate of the median delay is compared with the true one;
in the end, the moments for which their commands are recorded with those that they meant.

    scripts/python research/delays.py --people 12
"""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean, stdev
from typing import Annotated

import typer
from novices import NOVICE, Novice
from people_tables import OFF
from pupils import InProcessPupil
from rich.console import Console
from rich.table import Table
from teachers import intention_of
from ways import Ways

from hitab_core.example import Example

DELAYS = (-0.2, 0.0, 0.3, 0.6, 0.9)
"""Of the people, s; who is early sees ahead, and nothing is recorded for what is to come."""

AFTER = (5, 10, 20)
"""After so many commands to a world that ran the estimate is read."""


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


def trained(number: int, delay: float, seed: int) -> tuple[list[float], list[tuple[float, bool]]]:
    """Have one person train a team.

    Returns:
        What the agent made of the delay after each late command, s; and how far off commands are
        recorded, see `Diary.off`.
    """
    pupil = WatchedPupil(seed * 1000 + number)
    person = Novice(intention_of(number), NOVICE, seed * 1000 + number, ways=Ways(delay=delay))
    diary = person.train(pupil)
    pupil.close()
    return pupil.estimates, diary.off


def main(
    people: Annotated[int, typer.Option(help="How many people of each delay.", min=2)] = 12,
    seed: Annotated[int, typer.Option(help="Of the people.")] = 77,
) -> None:
    """Compare estimates of people's delays, and moments, with the true ones."""
    heads = [f"bias ± spread after {n}, s" for n in AFTER]
    table = Table("true median, s", *heads, f"more than {OFF} s off", "in another state")
    for delay in DELAYS:
        found = [trained(number, delay, seed) for number in range(people)]
        cells = []
        for after in AFTER:
            errors = [ones[after - 1] - max(0.0, delay) for ones, _ in found if len(ones) >= after]
            cells.append(
                f"{fmean(errors):+.2f} ± {stdev(errors):.2f} ({len(errors)})"
                if len(errors) > 1
                else "too few"
            )
        off = [one for _, ones in found for one in ones]
        cells.append(f"{fmean(abs(seconds) > OFF for seconds, _ in off):.0%}")
        cells.append(f"{fmean(other for _, other in off):.0%}")
        table.add_row(f"{delay}", *cells)
    Console(width=150).print(table)


if __name__ == "__main__":
    typer.run(main)
