"""Measures how long keepers keep the ball from takers at full speed: trained ones, and rules.

By default three against two in 20 m x 20 m; collisions on, UT Austin's takers, which see as the
keepers do.
The rules are hand-written automata of the same words as the trained ones, with no example: two
numbers, how near a taker may come to the ball and how clear a lane must be. Random ones draw both
anew for each episode. All play the same episodes, so the difference is one of pairs. The word of
a keeper whose ball it is not can be swapped.

    scripts/python research/records.py --episodes 60 --seed 6001 --longest 1500
    scripts/python research/records.py --sight full --keepers rules --near 3.5,4.5 --slack 0,0.5
    scripts/python research/records.py --keepers rules --near inf --slack=-inf    # kickable: pass
    scripts/python research/records.py --keepers random --away GetOpen,Support
    scripts/python research/records.py --game 5v4 --side 25 --away Support --seed 6001
"""

from __future__ import annotations

import json as js
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import repeat
from pathlib import Path
from random import Random
from statistics import median
from typing import Annotated, Any

import typer
from games import size_of

from hitab_bringup.libraries.opened_library import open_library
from hitab_client.measures import estimate
from hitab_client.runs.shipped import shipped
from hitab_core import (
    START,
    Automaton,
    BehaviorLibrary,
    Domain,
    HandWritten,
    Repertoire,
    Term,
    has,
)
from hitab_core.learning.transition_learning import learn_transitions
from hitab_world.inprocess import perform, play
from keepaway_world.parameters import SIGHTS, KeepawayParameters, variant
from keepaway_world.world import KeepawayWorld

NEAR, SLACK = 4.5, 0.2  # m: the better of two pairs, tried with other seeds
PASS = "SwiftPassTo(clearest_keeper)"
NEAREST, CLEAREST = (0.0, 10.0), (-1.0, 2.0)  # m: between which random numbers are drawn
TRAINED_AWAY = "GetOpen"  # the lessons' word for a keeper whose ball it is not
KEEPERS = ("both", "trained", "rules", "random")
CHUNK = 5  # episodes between two reports of progress
CONFIDENT = 1.96  # standard errors to either side: an interval that covers 95%


@dataclass(frozen=True)
class Result:
    """What some keepers did.

    Attributes:
        title: of the keepers.
        seconds: of each episode; those that were cut off count as they are.
        ended: why episodes ended; "cut" if they were cut off.
        rate: cycles per second of one core.
    """

    title: str
    seconds: Sequence[float]
    ended: Mapping[str, int]
    rate: float

    def line(self) -> str:
        """Return a line of text."""
        hold = estimate(self.seconds).rounded()
        ended = ", ".join(f"{count} {why}" for why, count in sorted(self.ended.items()))
        middle = f"median {median(self.seconds):.1f} s, n = {len(self.seconds)}"
        return (
            f"{self.title:40} {hold['mean']:7.2f} ± {hold['se']:5.2f} s, "
            f"{middle}   {ended}   {self.rate:.0f} cycles/s"
        )


def rules(domain: Domain, near: float, slack: float, away: str) -> dict[str, Automaton]:
    """Return hand-written automata over the words that the lessons use.

    Args:
        domain: with those words.
        near: distance of a taker from the ball at which it is passed, m.
        slack: by how much the takers must miss a pass, m.
        away: word of a keeper whose ball it is not.
    """

    def meet(kickable: float) -> str:
        return "StopBall" if kickable else "MeetBall"

    def hold(kickable: float, taker: float, clear: float) -> str:
        if not kickable:
            return "MeetBall"
        return PASS if taker <= near and clear > slack else "StopBall"

    def whose(anothers: float) -> str:
        return away if anothers else "PlayBall"

    states = ("MeetBall", "StopBall", PASS)
    play_ball = Automaton(
        "PlayBall",
        tuple(map(Term.parse, states)),
        tuple(map(Term.parse, ("BallIsKickable", "TakerToBall", "LaneSlack(clearest_keeper)"))),
        {
            **dict.fromkeys((START, "MeetBall"), HandWritten(meet, (0,))),
            "StopBall": HandWritten(hold, (0, 1, 2)),
            PASS: HandWritten(lambda: "MeetBall"),
        },
    )
    keepaway = Automaton(
        "Keepaway",
        (Term(away), Term("PlayBall")),
        (Term("BallIsAnothers"),),
        dict.fromkeys((START, away, "PlayBall"), HandWritten(whose, (0,))),
    )
    return {automaton.name: automaton for automaton in (play_ball, keepaway)}


def random_rules(domain: Domain, away: str, seed: int) -> Iterator[Repertoire]:
    """Return rules with random numbers, one after another."""
    draw = Random(seed).uniform
    while True:
        yield Repertoire(domain, rules(domain, draw(*NEAREST), draw(*CLEAREST), away))


def swapped(automaton: Automaton, domain: Domain, away: str) -> Automaton:
    """Return the trained automaton as if its examples were of another word than the lessons'."""
    examples = tuple(
        replace(
            example,
            state=example.state.replace(TRAINED_AWAY, away),
            next_state=example.next_state.replace(TRAINED_AWAY, away),
        )
        for example in automaton.examples
    )
    states = tuple(Term(away) if s.name == TRAINED_AWAY else s for s in automaton.states)
    scales = [domain.scale_of(feature) for feature in automaton.features]
    transitions = learn_transitions(examples, scales)
    return replace(automaton, states=states, examples=examples, transitions=transitions)


def trained_team(opened: BehaviorLibrary, away: str) -> Repertoire:
    """Return what a library holds, with another word for a keeper whose ball it is not."""
    automata = dict(opened.load())
    automata["Keepaway"] = swapped(automata["Keepaway"], opened.domain, away)
    return Repertoire(opened.domain, automata)


def measure(
    title: str,
    teams: Iterator[Repertoire],
    world: KeepawayWorld,
    episodes: int,
    longest: float,
    some: int,
) -> Result:
    """Play episodes; none longer than ``longest`` seconds, if that is not 0.

    Each of the teams plays ``some`` of them.
    """
    cut = round(longest / world.cycle_seconds) or None
    played: list[Any] = []
    began = time.process_time()
    while len(played) < episodes:
        players = perform(world, next(teams), "Keepaway")
        count = min(some, episodes - len(played))
        played += play(world, players, count, first=len(played), cycles_max=cut)
        print(f"  {title}: {len(played)} of {episodes} episodes", flush=True)
    spent = time.process_time() - began
    return Result(
        title,
        [one.seconds for one in played],
        Counter(one.ended or "cut" for one in played),
        sum(one.cycles for one in played) / spent,
    )


def difference(one: Result, other: Result) -> str:
    """Return the mean difference of two results over the same episodes, with its error."""
    apart = estimate([a - b for a, b in zip(one.seconds, other.seconds, strict=True)]).rounded()
    mean, within = apart["mean"], CONFIDENT * apart["se"]
    return (
        f"{one.title} - {other.title}: {mean:.2f} ± {apart['se']:.2f} s "
        f"(95%: {mean - within:.1f} to {mean + within:.1f})"
    )


def _numbers(text: str, option: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise typer.BadParameter(f'"{text}" is not a list of numbers', param_hint=option) from None


def _one_of(text: str, known: Sequence[str], option: str) -> None:
    if text not in known:
        raise typer.BadParameter(f'there is no "{text}" {has(known, text)}', param_hint=option)


def _game(text: str, side: float, sight: str, takers: str) -> KeepawayParameters:
    """Return the game of a text such as "4v3" in a square box.

    Raises:
        BadParameter: if there is no such game.
    """
    keepers, others = size_of(text)
    try:
        return variant(
            "standard",
            keepers=keepers,
            takers=others,
            width=side,
            height=side,
            sight=sight,
            taker_policy=takers,
        )
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--game, --side") from None


def main(
    episodes: Annotated[int, typer.Option(help="Episodes for each kind of keepers.", min=2)] = 60,
    seed: Annotated[int, typer.Option(help="Of the run: the same seed, the same episodes.")] = 1,
    sight: Annotated[str, typer.Option(help="quantised (noisy), full, or both.")] = "both",
    takers: Annotated[
        str, typer.Option(help="reference (UT Austin's) or intercept.")
    ] = "reference",
    game: Annotated[str, typer.Option(help="Keepers against takers, as in 4v3.")] = "3v2",
    side: Annotated[float, typer.Option(help="Of the square box, m.")] = 20.0,
    keepers: Annotated[str, typer.Option(help="both, trained, rules or random.")] = "both",
    near: Annotated[str, typer.Option(help="m, the rules' first number; or several.")] = f"{NEAR}",
    slack: Annotated[str, typer.Option(help="m, the rules' second one; or several.")] = f"{SLACK}",
    away: Annotated[
        str, typer.Option(help="Word of a keeper whose ball it is not; or several.")
    ] = TRAINED_AWAY,
    library: Annotated[Path | None, typer.Option(help="Folder of a trained library.")] = None,
    longest: Annotated[float, typer.Option(help="Cut episodes off after, s; 0: never.")] = 0.0,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Measure hold times against takers at full speed."""
    _one_of(sight, (*SIGHTS, "both"), "--sight")
    _one_of(takers, ("intercept", "reference"), "--takers")
    _one_of(keepers, KEEPERS, "--keepers")
    seen = SIGHTS if sight == "both" else (sight,)
    games = {eyes: _game(game, side, eyes, takers) for eyes in seen}
    pairs = [(n, s) for n in _numbers(near, "--near") for s in _numbers(slack, "--slack")]
    opened = open_library(library or shipped("libraries", "keepaway_fullspeed"))
    words = away.split(",")
    for word in words:
        _one_of(word, sorted(opened.domain.behaviors), "--away")
    teams: dict[str, Callable[[], Iterator[Repertoire]]] = {}
    for word in words:
        if keepers in ("both", "trained"):
            team = trained_team(opened, word)
            examples = sum(len(automaton.examples) for automaton in team.automata.values())
            teams[f"trained ({examples} examples), {word}"] = partial(repeat, team)
        if keepers in ("both", "rules"):
            for n, s in pairs:
                team = Repertoire(opened.domain, rules(opened.domain, n, s, word))
                teams[f"rules (near {n:g}, slack {s:g}), {word}"] = partial(repeat, team)
        if keepers == "random":
            teams[f"random rules, {word}"] = partial(random_rules, opened.domain, word, seed)
    figures: dict[str, Any] = {
        "seed": seed,
        "game": game,
        "side": side,
        "takers": takers,
        "library_digest": opened.digest,
    }
    some = 1 if keepers == "random" else CHUNK
    for eyes, parameters in games.items():
        print(f"{game} in {side:g} m, sight {eyes}, takers {takers}, seed {seed}", flush=True)
        results = [
            measure(title, team(), KeepawayWorld(parameters, seed), episodes, longest, some)
            for title, team in teams.items()
        ]
        for result in results:
            print(result.line())
        for other in results[1:]:
            print(difference(results[0], other))
        figures[eyes] = {
            result.title: {
                **estimate(result.seconds).rounded(),
                "ended": dict(result.ended),
                "cycles_per_cpu_s": round(result.rate),
                "seconds": list(result.seconds),
            }
            for result in results
        }
    if json:
        Path(json).write_text(js.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
