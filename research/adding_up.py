"""Measures whether a team gets better with each correction, and what spoiled it if it did not.

Novices (`novices.py`) with the studio's defaults (`ways.STUDIO`) teach courses of several lengths.
After each trial, what was learned so far is compared with what was intended (`agreement.py`). The
team plays with what its plans knew after parts of their trials, and in the end once more without
the commands that say what was not intended.

    scripts/python research/adding_up.py --people 40 --jobs 2
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import pairwise
from random import Random
from statistics import fmean, stdev
from typing import Annotated, Any

import typer
from agreement import decisions, objections
from intentions import Plan
from novices import NOVICE, Novice
from practice import Scene
from pupils import InProcessPupil, Sight
from second_thoughts import as_seen
from simulated_people import Course
from teachers import PAPER_S, SHARE, intention_of, own_hold_times, playing
from ways import STUDIO

from hitab_core import START, Automaton, Term
from hitab_core.example import Example
from hitab_core.learning import relearned
from hitab_world import Placement
from keepaway_world.domain import DOMAIN

OWN_EPISODES = 200
"""Episodes that each intention plays itself."""

DROP = 0.15
"""A plan got worse that decides so much more otherwise, added up over the kinds of decisions."""

PARTS = (0.25, 0.5, 0.75, 1.0)
"""The team plays with what each plan knew after such parts of its trials."""

Known = Mapping[str, Sequence[Example]]
"""The examples of each plan."""


class Longer(Novice):
    """A novice who shows and watches each plan, and games, ``times`` as often."""

    times = 1

    def _practise(
        self, course: Course, scenes: Callable[[Random, int], Scene], shown: int, watched: int
    ) -> None:
        super()._practise(course, scenes, self.times * shown, self.times * watched)


class Recorded(InProcessPupil):
    """A team that keeps what it knew after each trial: ``course`` has the plan, and `Known`."""

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self.course: list[tuple[str, Known]] = [("", {})]

    def place(self, placements: Iterable[Placement], *, new_episode: bool = True) -> Sight:
        """Arrange the field; see `Pupil.place`."""
        if new_episode:
            self._note()
        return super().place(placements, new_episode=new_episode)

    def save(self, *, keep_unused: bool = False) -> None:
        """Save what was trained; see `Pupil.save`."""
        self._note()
        super().save(keep_unused=keep_unused)

    def _note(self) -> None:
        self.course.append((self._plan, {**self.course[-1][1], self._plan: self.examples()}))


def learned(plan: Plan, examples: Sequence[Example]) -> Automaton:
    """Return what is learned from examples."""
    states, features = (tuple(map(Term.parse, of)) for of in (plan.states, plan.features))
    return relearned(Automaton(plan.name, states, features, {}, (), tuple(examples)), DOMAIN)


def wrong(plan: Plan, e: Example) -> str:
    """Return the origin of an example that says what was not intended; "" if it was."""
    if e.next_state in plan.fitting(e.state, as_seen(plan, e.features)):
        return ""
    return "answer" if not e.readings else "default" if e.is_default else "command"


def between(plan: Plan, before: Sequence[Example], after: Sequence[Example]) -> str:
    """Return what came between: examples that say what was not intended, and where from."""
    old = {e.number: e for e in before}
    new = {e.number: e for e in after}
    moved = {wrong(plan, e) and "moved" for n, e in new.items() if n in old and e != old[n]}
    came = {wrong(plan, e) for n, e in new.items() if n not in old}
    gone = {"deleted" for n in old.keys() - new.keys() if not wrong(plan, old[n])}
    return ", ".join(sorted((moved | came | gone) - {""})) or "only what was intended"


def taught(number: int, times: int, episodes: int, seed: int) -> dict[str, Any]:
    """Have one person teach a course so many times as long; return the figures."""
    intention, own_seed = intention_of(number), seed * 1000 + number
    pupil = Recorded(own_seed)
    person = Longer(intention, NOVICE, own_seed, ways=STUDIO)
    person.times = times
    person.train(pupil)
    pupil.close()
    own, _ = own_hold_times(intention.name, OWN_EPISODES, seed + 7)
    plans = {plan.name: plan for plan in intention.plans}
    records = decisions(intention.name, seed)

    def otherwise(name: str, known: Known) -> float:
        automaton = learned(plans[name], known[name])
        return sum(objections(plans[name], automaton, records[name]).values())

    def part_of(plan: str, part: float) -> Sequence[Example]:
        known = [known[plan] for name, known in pupil.course if name == plan]
        return known[round(part * (len(known) - 1))] if known else ()

    def hold(part: float, left_out: str = "") -> float:
        known = {name: part_of(name, part) for name in plans}
        if not all(any(e.state == START for e in examples) for examples in known.values()):
            return 0.0
        team = {
            n: learned(p, [e for e in known[n] if not left_out or wrong(p, e) != left_out])
            for n, p in plans.items()
        }
        return fmean(playing(team, intention.plans[-1].name, seed + 7)(episodes, 0)) / own

    def given(part: float) -> int:
        examples = (e for name in plans for e in part_of(name, part))
        return sum(bool(e.readings) and not e.is_default for e in examples)

    trials = [(name, known) for name, known in pupil.course[1:] if known[name]]
    drops, rises = Counter[str](), 0
    for (plan, before), (name, after) in pairwise(trials):
        if plan == name and before[name] != after[name]:
            change = otherwise(name, after) - otherwise(name, before)
            rises += change < -DROP
            if change > DROP:
                drops[between(plans[name], before[name], after[name])] += 1
    return {
        "curve": [(given(part), hold(part)) for part in PARTS],
        "without wrong commands": hold(1.0, "command"),
        "needed": max(PAPER_S / own, SHARE),
        "better": rises,
        "worse": drops,
    }


def main(
    people: Annotated[int, typer.Option(help="How many people.", min=2)] = 40,
    longer: Annotated[list[int] | None, typer.Option(help="Times as many trials.")] = None,
    episodes: Annotated[int, typer.Option(help="Episodes of each team.", min=2)] = 100,
    seed: Annotated[int, typer.Option(help="Seed of people and games.")] = 90317,
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 1,
) -> None:
    """Have novices teach courses of several lengths, and compare the teams in pairs."""
    first: list[float] = []
    with ProcessPoolExecutor(jobs) as pool:
        for times in longer or (1, 2):
            teach = partial(taught, times=times, episodes=episodes, seed=seed)
            found = list(pool.map(teach, range(people)))
            for i, part in enumerate(PARTS):
                holds = [f["curve"][i][1] for f in found]
                print(
                    f"{times} times as long, after {part:.0%}: "
                    f"{fmean(f['curve'][i][0] for f in found):.1f} commands, "
                    f"{sum(f['curve'][i][1] >= f['needed'] for f in found)} of {people} succeed, "
                    f"{fmean(holds):.2f} ± {stdev(holds) / people**0.5:.2f} of own"
                )
            first = first or holds
            more = [a - b for a, b in zip(holds, first, strict=True)]
            without = fmean(f["without wrong commands"] for f in found)
            print(
                f"  more than the first: {fmean(more):+.2f} ± {stdev(more) / people**0.5:.2f}; "
                f"without wrong commands {without:.2f}; trials after which a plan was better: "
                f"{sum(f['better'] for f in found)}, worse: "
                f"{dict(sum((f['worse'] for f in found), Counter()))}"
            )


if __name__ == "__main__":
    typer.run(main)
