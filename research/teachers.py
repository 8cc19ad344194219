"""Measures how many of a hundred simulated people train a team that does what they intended.

Each person has an intention (`intentions.py`), reacts late, wavers, looks away and presses wrong
keys (`simulated_people.py`, `trial.py`), and trains three keepers while the world runs
(`practice.py`, `pupils.py`). The team holds at most 60 examples, default ones counted; what was
taken back is not. A person succeeds whose team holds the ball for 14.6 s on average, the paper's
figure, and for 80 % of what the intention itself holds it.
research/teachers.md describes the method.

    scripts/python research/teachers.py --people 100 --json teachers.json
    scripts/python research/teachers.py --people 20 --causes
    scripts/python research/teachers.py --people 20 --each-aid
    scripts/python research/teachers.py --people 20 --wrong 0.1 --without reaction --diagnose
    scripts/python research/teachers.py --people 100 --novices --delay 0
"""

from __future__ import annotations

import json as js
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from statistics import fmean, stdev
from typing import Annotated, Any

import typer
from agreement import decisions, objections
from finished_runs import FinishedRuns, Resume
from habits import Habits
from intentions import INTENTIONS, Intention
from novices import NOVICE, Novice
from people_tables import by_chance, curve, diagnosis, row
from pupils import InProcessPupil
from simulated_people import Person
from topic_pupil import TopicPupil
from ways import AS_THEY_ARE, Ways

from hitab_core import ASSISTANTS, Automaton, HitabError, Repertoire, has
from hitab_world.inprocess import perform, play
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld

PAPER_S = 14.6
"""Mean hold time of the paper's trained keepers, s."""

SHARE = 0.8
"""The part of the intention's own hold time that the team has to reach."""

HOPELESS = (20, 0.4)
"""A team that after so many episodes holds for less than this part of what it needs has failed."""

AIDS = (
    "reaction",
    "supersede",
    "sides",
    "ahead",
    "review",
    "questions",
    "pace",
    "unshown",
    "late",
    "correction",
    "feature",
)
"""Aids of the engine: it estimates when commands were due; they outrank default examples; one
among default examples holds for a side of a circle; trees look one step ahead; people look through
what was recorded, move and delete commands; they answer the agent's questions; people slow the
world down where they come too late; the last ones are the kinds of questions besides
contradictions."""

NOTHING = Habits(reaction=(0.0, 0.0), waver=0.0, inattention=0.0, wrong=0.0)


@dataclass(frozen=True)
class Setting:
    """What is measured.

    Attributes:
        habits: of all people.
        aids: of the engine that people use.
        episodes: that each team plays.
        seed: of the people; teams play with another one.
        budget: the most examples.
        diagnose: whether to compare what was learned with what was intended.
        own_episodes: that each intention plays itself; the teams' episodes are among them.
        novices: whether the people are novices.
        over_topics: whether people train nodes; with all aids only.
        ways: how people press keys and use time.
    """

    habits: Habits
    aids: frozenset[str] = frozenset(AIDS)
    episodes: int = 200
    seed: int = 2026
    budget: int = 60
    diagnose: bool = False
    own_episodes: int = 200
    over_topics: bool = False
    novices: bool = False
    ways: Ways = AS_THEY_ARE

    @property
    def games(self) -> int:
        """The seed of the episodes that teams and intentions play."""
        return self.seed + 7

    def seed_of(self, number: int) -> int:
        """Return the seed of a person, and of the world in which the person trains."""
        return self.seed * 1000 + number


Play = Callable[[int, int], list[float]]
"""``play(count, first)`` returns the lengths of some episodes from the ``first`` one on, s."""


def playing(automata: Mapping[str, Automaton], top: str, seed: int) -> Play:
    """Return how a team plays that performs ``top``."""
    world = KeepawayWorld(seed=seed)
    players = perform(world, Repertoire(DOMAIN, automata), top)
    return lambda count, first: [p.seconds for p in play(world, players, count, first=first)]


def hold_times(play: Play, episodes: int, needed: float = 0.0) -> list[float]:
    """Return the lengths of some episodes, s; fewer if the team is hopeless."""
    count, part = HOPELESS
    first = min(count, episodes)
    times = play(first, 0)
    if fmean(times) < part * needed:
        return times
    return times + play(episodes - first, first)


@cache
def own_hold_times(name: str, episodes: int, seed: int) -> tuple[float, float]:
    """Return for how long an intention holds the ball when it plays itself, and its spread, s."""
    intention = INTENTIONS[name]
    top = intention.plans[-1].name
    times = hold_times(playing(intention.automata(), top, seed), episodes)
    return fmean(times), stdev(times)


def intention_of(number: int) -> Intention:
    """Return the intention of a person."""
    return list(INTENTIONS.values())[number % len(INTENTIONS)]


def person_of(number: int, setting: Setting) -> Person:
    """Return a person."""
    if setting.novices:
        return Novice(
            intention_of(number),
            setting.habits,
            setting.seed_of(number),
            answers="questions" in setting.aids,
            estimated="reaction" in setting.aids,
            ways=setting.ways,
        )
    return Person(
        intention_of(number),
        setting.habits,
        setting.seed_of(number),
        setting.budget,
        estimated="reaction" in setting.aids,
        reviews="review" in setting.aids,
        answers="questions" in setting.aids,
        slows="pace" in setting.aids,
        ways=setting.ways,
    )


def pupil_of(number: int, setting: Setting) -> InProcessPupil | TopicPupil:
    """Return the team that a person trains."""
    if setting.over_topics:
        return TopicPupil(setting.seed_of(number))
    return InProcessPupil(
        setting.seed_of(number),
        supersede="supersede" in setting.aids,
        sides="sides" in setting.aids,
        ahead="ahead" in setting.aids,
        without={*AIDS} & {*ASSISTANTS} - setting.aids,
    )


def train_and_play(number: int, setting: Setting) -> dict[str, Any]:
    """Have one person train a team, and the team play; return the figures."""
    intention = intention_of(number)
    own, spread = own_hold_times(intention.name, setting.own_episodes, setting.games)
    needed = max(PAPER_S, SHARE * own)
    person, pupil = person_of(number, setting), pupil_of(number, setting)
    figures: dict[str, Any] = {"person": number, "intention": intention.name, "own_s": own}
    figures["by_chance"] = by_chance(own, spread, needed, setting.episodes, setting.own_episodes)
    try:
        diary = person.train(pupil)
        known = pupil.repertoire
    except HitabError as error:  # a person would stop at an error, and have no team
        return figures | _no_team(str(error), pupil)
    finally:
        pupil.close()
    if diary.failure:
        return figures | diary.figures() | _no_team(diary.failure, pupil)
    trained = {plan.name: known.automata[plan.name] for plan in intention.plans}
    top = intention.plans[-1].name
    figures |= {**diary.figures(), "given": pupil.given, "held": pupil.held}
    play = playing(trained, top, setting.games)
    figures |= result(hold_times(play, setting.episodes, needed), needed)
    if setting.diagnose:
        records = decisions(intention.name, setting.seed)
        figures["objections"] = {
            f"{plan.name}: {kind}": share
            for plan in intention.plans
            for kind, share in objections(plan, trained[plan.name], records[plan.name]).items()
        }
    return figures


def result(times: Sequence[float], needed: float) -> dict[str, Any]:
    """Return the figures of a team that has played."""
    hold = fmean(times)
    return {"hold_s": hold, "se": stdev(times) / len(times) ** 0.5, "success": hold >= needed}


def _no_team(failure: str, pupil: InProcessPupil | TopicPupil) -> dict[str, Any]:
    examples = {"given": pupil.given, "held": pupil.held}
    return {"failure": failure, **examples, "hold_s": 0.0, "se": 0.0, "success": False}


def measure(
    people: Sequence[int], setting: Setting, jobs: int, title: str, finished: FinishedRuns
) -> list[dict[str, Any]]:
    """Measure some people, but those that have finished; Ctrl-C returns those that are done."""
    names = {number: f"{title}, person {number}" for number in people}
    done = [finished.figures[name] for name in names.values() if name in finished.figures]
    people = [number for number in people if names[number] not in finished.figures]
    began = time.monotonic()

    def note(figures: dict[str, Any]) -> None:
        finished.add(names[figures["person"]], figures)
        done.append(figures)
        good = sum(f["success"] for f in done)
        print(
            f"\r  {title}: {len(done)}/{len(names)} people, {good} succeeded, "
            f"{time.monotonic() - began:.0f} s   ",
            end="",
            flush=True,
        )

    try:
        if jobs > 1:
            with ProcessPoolExecutor(jobs) as pool:
                for future in as_completed(
                    [pool.submit(train_and_play, n, setting) for n in people]
                ):
                    note(future.result())
        else:
            for number in people:
                note(train_and_play(number, setting))
    except KeyboardInterrupt:
        print("\n  interrupted; these are the figures so far", end="")
    print()
    return sorted(done, key=lambda f: f["person"])


CAUSES: Mapping[str, Callable[[Habits], Habits]] = {
    "nothing": lambda h: NOTHING,
    "reaction": lambda h: replace(NOTHING, reaction=h.reaction),
    "wavering": lambda h: replace(NOTHING, waver=h.waver),
    "inattention": lambda h: replace(NOTHING, inattention=h.inattention),
    "wrong commands": lambda h: replace(NOTHING, wrong=h.wrong or 0.1),
    "all but wrong commands": lambda h: replace(h, wrong=0.0),
    "all": lambda h: replace(h, wrong=h.wrong or 0.1),
}


def span(text: str) -> tuple[float, float]:
    """Parse a span of seconds such as ``0.2-0.4``."""
    low, _, high = text.partition("-")
    try:
        span = float(low), float(high or low)
    except ValueError:
        raise typer.BadParameter(f'"{text}" is not a span of seconds such as 0.2-0.4') from None
    if not 0.0 <= span[0] <= span[1] <= 2.0:
        raise typer.BadParameter(f"{text}: give two times from 0 to 2 s, the shorter one first")
    return span


def settings(habits: Habits, causes: bool, only: Sequence[str]) -> dict[str, Habits]:
    """Return the habits to measure, by title."""
    if unknown := sorted({*only} - {*CAUSES}):
        raise typer.BadParameter(f'there is no cause "{unknown[0]}" {has(CAUSES, unknown[0])}')
    if not causes and not only:
        return {"as asked": habits}
    return {title: make(habits) for title, make in CAUSES.items() if not only or title in only}


def cases(setting: Setting, habits: Mapping[str, Habits], each_aid: bool) -> dict[str, Setting]:
    """Return the settings to measure, by title."""
    found: dict[str, Setting] = {}
    for title, some in habits.items():
        found[title] = replace(setting, habits=some)
        if each_aid:
            for aid in AIDS:
                if aid in setting.aids:
                    aids = setting.aids - {aid}
                    found[f"{title}, without {aid}"] = replace(found[title], aids=aids)
            found[f"{title}, without any aid"] = replace(found[title], aids=frozenset())
    return found


def main(
    people: Annotated[int, typer.Option(help="How many people.", min=1)] = 100,
    first: Annotated[int, typer.Option(help="Number of the first person.", min=0)] = 0,
    reaction: Annotated[str, typer.Option(help="Shortest and longest time, s.")] = "0.2-0.4",
    waver: Annotated[float, typer.Option(help="By how much edges waver.", min=0, max=1)] = 0.15,
    inattention: Annotated[
        float, typer.Option(help="Fraction of decisions that come late or never.", min=0, max=1)
    ] = 0.1,
    wrong: Annotated[float, typer.Option(help="Fraction of wrong commands.", min=0, max=1)] = 0.0,
    without: Annotated[
        list[str] | None, typer.Option(help=f"Aids to switch off: {', '.join(AIDS)}.")
    ] = None,
    each_aid: Annotated[bool, typer.Option(help="Also switch each aid off by itself.")] = False,
    causes: Annotated[bool, typer.Option(help="Measure each cause by itself.")] = False,
    only: Annotated[list[str] | None, typer.Option(help="Only these causes.")] = None,
    diagnose: Annotated[bool, typer.Option(help="Say what was learned otherwise.")] = False,
    over_topics: Annotated[
        bool, typer.Option(help="Train nodes over topics and services, not in one process.")
    ] = False,
    episodes: Annotated[
        int | None, typer.Option(help="Episodes of each team; 200, of novices 400.", min=2)
    ] = None,
    own_episodes: Annotated[
        int | None,
        typer.Option(help="Episodes that each intention plays itself; as many.", min=2),
    ] = None,
    novices: Annotated[
        bool, typer.Option(help="Novices, who have habits of their own (novices.py).")
    ] = False,
    sight: Annotated[
        float,
        typer.Option(help="By how much novices see distances and angles off.", min=0, max=1),
    ] = NOVICE.sight,
    delay: Annotated[
        float | None,
        typer.Option(help="People are late by about this, s; 0: in time; negative: early."),
    ] = None,
    pace_of_world: Annotated[
        float, typer.Option(help="Of the world while they teach, of its usual.", min=0.01, max=1)
    ] = 1.0,
    answers: Annotated[int, typer.Option(help="Answers between trials.", min=1)] = 1,
    surprised: Annotated[
        bool, typer.Option(help="Only what is so or not so, and wrong changes, surprise people.")
    ] = False,
    freezes: Annotated[
        float, typer.Option(help="Share of commands that freeze the world first.", min=0, max=1)
    ] = 0.0,
    goes_back: Annotated[
        float, typer.Option(help="Share of commands given again by going back.", min=0, max=1)
    ] = 0.0,
    budget: Annotated[int, typer.Option(help="The most examples that a team holds.", min=1)] = 60,
    seed: Annotated[int, typer.Option(help="Seed of people and games.")] = 2026,
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 1,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    resume: Resume = "",
) -> None:
    """Have simulated people train keepers, and measure how many succeed."""
    off = {*(without or ())}
    if unknown := sorted(off - {*AIDS}):
        raise typer.BadParameter(f'there is no aid "{unknown[0]}" {has(AIDS, unknown[0])}')
    habits = Habits(reaction=span(reaction), waver=waver, inattention=inattention, wrong=wrong)
    if novices:
        habits = replace(NOVICE, inattention=inattention, wrong=wrong, sight=sight)
    aids = frozenset(AIDS) - off
    if over_topics and (off or each_aid):
        raise typer.BadParameter("nodes have all aids; leave out --over-topics, or the others")
    ways = Ways(delay, pace_of_world, answers, surprised, freezes, goes_back)
    usual = 400 if novices else 200
    setting = Setting(
        habits,
        aids,
        episodes or usual,
        seed,
        budget,
        diagnose,
        own_episodes or usual,
        over_topics,
        novices,
        ways,
    )
    given = {**asdict(setting), "aids": sorted(setting.aids)}
    finished = FinishedRuns(resume, given)
    measured: dict[str, list[dict[str, Any]]] = {}
    asked = settings(habits, causes, only or ())
    for title, case in cases(setting, asked, each_aid).items():
        found = measure(range(first, first + people), case, jobs, title, finished)
        measured[title] = found
        if json:
            curves = {name: curve(those) for name, those in measured.items()}
            text = js.dumps({**given, "people": measured, "curves": curves}, indent=1)
            Path(json).write_text(text + "\n", encoding="utf-8")
        if len(found) < people:
            break  # interrupted
    for title, found in measured.items():
        print(row(title, found))
        if diagnose:
            print("\n".join(diagnosis(found)))


if __name__ == "__main__":
    typer.run(main)
