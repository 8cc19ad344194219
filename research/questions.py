"""Counts the questions that the shipped lessons' examples leave open, and what answers do.

For each state of each shipped automaton the questions are asked one after the other, each answered
as the shipped automaton decides, until none is left. Situations to ask in are the values of all
examples of the automaton and, with ``--episodes``, readings of agents that perform the library's
highest behavior. What is learned, before and after the answers, is compared with the shipped
automaton in these situations. ``--no-tie-rule`` learns without the rule that ties prefer boolean
features; shipped automata are always learned with it.

    scripts/python research/questions.py
    scripts/python research/questions.py --no-tie-rule --episodes 20 --json questions.json
"""

from __future__ import annotations

import json as js
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_bringup.opened_library import open_library
from hitab_client.shipped import shipped_folders
from hitab_core import FLAGS, Automaton, Repertoire, Use, agent_seed
from hitab_core.advice.ambiguity import ambiguities
from hitab_core.advice.evidence import Evidence
from hitab_core.domain import BOOLEAN_SCALE, Domain, Scale
from hitab_core.running import RunContext, Senses
from hitab_core.running.live_features import live_features
from hitab_world.inprocess import play
from hitab_world.world import World
from keepaway_world.world import KeepawayWorld

NO_TIE_RULE = "tree(boolean_first=False)"
MOST = 20  # questions about one state
READINGS = 300  # of a state, and as many of all others
CYCLES = 400  # of an episode at most

Readings = list[tuple[str, tuple[float, ...]]]
"""The state that was active, and the values of the automaton's features."""

PLAYED: dict[str, tuple[str, Callable[[int], World]]] = {
    "keepaway": ("Keepaway", lambda seed: KeepawayWorld(seed=seed)),
    "keepaway_predictive": ("Keepaway", lambda seed: KeepawayWorld(seed=seed)),
    "foraging": ("Forage", lambda seed: ForagingWorld(ForagingParameters(duration=40.0), seed)),
}
"""What the agents of a library perform for ``--episodes``, and where."""


@dataclass(frozen=True)
class AskedQuestion:
    """The questions about one state.

    Attributes:
        right_before, right_after: share of the situations in which what is learned decides as the
            shipped automaton.
    """

    library: str
    automaton: str
    state: str
    questions: tuple[str, ...]
    right_before: float
    right_after: float


class WatchedPlayer:
    """Performs a behavior, and writes down what each of its automata could read."""

    def __init__(self, repertoire: Repertoire, use: Use, name: str, seen: dict[str, Readings]):
        self.body = repertoire.domain.body(name)
        self._name, self._seen = name, seen
        self._random = random.Random()
        self._senses = Senses(self.body, repertoire.domain)
        self._context = RunContext(repertoire, self.body, self._senses, self._random.random)
        self._running = self._context.perform(use)

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode at Start."""
        self._random.seed(agent_seed(seed, episode, self._name))
        self._running.stop()
        self._running.start()

    def tick(self) -> None:
        """Write down what can be read, then decide."""
        self._senses.forget()
        values: dict[str, list[float]] = {}
        for automaton, _, value in live_features(self._running, self._context):
            values.setdefault(automaton, []).append(value)
        labels = list(values)
        for label, state in zip(labels, self._running.active_path, strict=False):
            reading = (state, tuple(values[label]))
            self._seen.setdefault(Use.parse(label).name, []).append(reading)
        self._running.tick()


def watched(repertoire: Repertoire, library: str, episodes: int, seed: int) -> dict[str, Readings]:
    """Return what the automata of a library could read in play, by automaton."""
    seen: dict[str, Readings] = {}
    if episodes and library in PLAYED:
        behavior, make = PLAYED[library]
        world = make(seed)
        use = Use.parse(behavior)
        players = {n: WatchedPlayer(repertoire, use, n, seen) for n in world.agents}
        play(world, players, episodes, cycles_max=CYCLES)
    return seen


def scales_and_units(automaton: Automaton, domain: Domain) -> tuple[list[Scale], list[str]]:
    """Return how the features of an automaton compare, and their units."""
    words = [domain.features.get(use.name) for use in automaton.features]
    flags = [use.name in FLAGS for use in automaton.features]
    return (
        [
            BOOLEAN_SCALE if flag or word is None else word.scale
            for word, flag in zip(words, flags, strict=True)
        ],
        ["" if word is None else word.unit for word in words],
    )


def asked(
    library: str, automaton: Automaton, domain: Domain, classifier: str, readings: Readings
) -> Iterator[AskedQuestion]:
    """Yield the questions about each state of an automaton."""
    scales, units = scales_and_units(automaton, domain)
    names = [str(use) for use in automaton.features]
    draw = random.Random(0)
    of_examples = [(example.state, example.features) for example in automaton.examples]
    for state in dict.fromkeys(example.state for example in automaton.examples):
        given = Evidence.of(state, automaton.examples, scales, names, units, classifier)
        right = replace(given, classifier="tree").learn()
        learned = given.learn()
        if right is None or learned is None or not names:
            continue
        situations = list(of_examples)
        for those in (
            [r for r in readings if r[0] == state],
            [r for r in readings if r[0] != state],
        ):
            situations += draw.sample(those, min(READINGS, len(those)))
        values = np.array([reading for _, reading in situations])
        complete = values[~np.isnan(values).any(axis=1)]
        wanted = right.predict(complete)
        before = float(np.mean(learned.predict(complete) == wanted))
        texts: list[str] = []
        while len(texts) < MOST and (left := ambiguities(given, situations)):
            texts.append(left[0].text)
            (answer,) = right.predict([left[0].situation])
            given = given.with_answer(left[0].situation, str(answer))
        after = given.learn()
        assert after is not None
        share = float(np.mean(after.predict(complete) == wanted))
        yield AskedQuestion(library, automaton.name, state, tuple(texts), before, share)


def main(
    episodes: Annotated[int, typer.Option(help="episodes to take readings from")] = 0,
    seed: Annotated[int, typer.Option(help="of the episodes")] = 41,
    no_tie_rule: Annotated[
        bool, typer.Option("--no-tie-rule", help="do not prefer boolean features in ties")
    ] = False,
    json: Annotated[Path | None, typer.Option(help="write the questions to this file")] = None,
) -> None:
    """Count the questions that the shipped lessons leave open."""
    classifier = NO_TIE_RULE if no_tie_rule else "tree"
    found: list[AskedQuestion] = []
    folders = [f for parent in shipped_folders("libraries") for f in parent.iterdir()]
    for folder in sorted(folders, key=lambda folder: folder.name):
        opened = open_library(folder)
        automata = opened.load()
        repertoire = Repertoire(opened.domain, automata)
        seen = watched(repertoire, folder.name, episodes, seed)
        for name, automaton in automata.items():
            rows = list(
                asked(folder.name, automaton, opened.domain, classifier, seen.get(name, []))
            )
            found += rows
            count = sum(len(row.questions) for row in rows)
            print(f"{folder.name}/{name}: {count} asked", flush=True)
            for row in rows:
                if row.questions or row.right_before < 1.0:
                    print(
                        f"  {row.state}: {len(row.questions)} asked; decides as shipped in "
                        f"{row.right_before:.1%} of the situations before, {row.right_after:.1%} "
                        "after"
                    )
                for text in row.questions:
                    print(f"    {text}")
    total = sum(len(row.questions) for row in found)
    worst = min((row.right_after for row in found), default=math.nan)
    print(
        f"{total} questions about {len(found)} states; decides as shipped in at least {worst:.1%}"
    )
    if json is not None:
        json.write_text(js.dumps([asdict(row) for row in found], indent=2) + "\n")


if __name__ == "__main__":
    typer.run(main)
