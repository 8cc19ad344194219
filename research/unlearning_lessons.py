"""Measures how well a training recovers from mistaken commands of the shipped keepaway lessons.

Some commands of the shipped library go to another state than was meant, chosen at random; their
default examples go along. Then a simulated person watches one keeper play beside two that play
right. Whenever its automata decide otherwise than those that were taught without mistakes, the
person corrects: the correction is recorded, the robot does what the person says, and the automaton
is learned again. The person stops after three episodes in a row without a correction.

- before: the automata with the mistakes.
- corrected: corrections alone; examples that an ordinary one overrules are left out.
- unlearned: the person also accepts each proposal to remove a mistake; see
  `hitab_core.advice.unlearning.propose`.
- spotless: corrections alone, if the mistaken commands had not been given at all.

Agreement is that with the automata taught without mistakes, in the situations that these get into,
counted by how often they do; once over all, and once over those in which they change state.

    scripts/python research/unlearning_lessons.py --json unlearning_lessons.json
    scripts/python research/unlearning_lessons.py --quick
"""

from __future__ import annotations

import json as js
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random
from statistics import fmean, median, stdev
from typing import Annotated, Any

import typer

from hitab_bringup.opened_library import open_library
from hitab_client.shipped import shipped
from hitab_core import (
    FLAGS,
    START,
    Automaton,
    Domain,
    Example,
    ExampleKind,
    Repertoire,
    Scale,
    Use,
)
from hitab_core.advice.proposals import Correction, ProposalKind
from hitab_core.advice.unlearning import propose
from hitab_core.domain import BOOLEAN_SCALE
from hitab_core.learning import learn_transitions
from hitab_core.transition_function import Decide, Values
from hitab_world.inprocess import AutomatonPlayer, perform, play
from keepaway_world.parameters import PAPER
from keepaway_world.world import KeepawayWorld

TOP = "Keepaway"
RATES = (0.1, 0.2)
EPISODES = 25
"""The most episodes that a person watches."""

CONTENT = 3
"""Episodes in a row without a correction after which a person stops."""

LONGEST = 600
"""Cycles after which an episode is broken off while watching."""

CORRECTED = 1000
"""Numbers of examples and commands of corrections begin here."""

Watch = Callable[[str, str, tuple[float, ...], Callable[[], float]], str]
"""``watch(automaton, state, features, draw)`` returns the next state."""

Situation = tuple[str, str, tuple[float, ...]]
"""An automaton, a state of it, and the values of its features."""


def in_force(examples: Sequence[Example]) -> list[Example]:
    """Return the examples without default ones that an ordinary one overrules."""
    said: dict[tuple[str, tuple[float, ...]], set[str]] = {}
    for e in examples:
        if not e.is_default:
            said.setdefault((e.state, e.features), set()).add(e.next_state)
    return [
        e
        for e in examples
        if not e.is_default or not said.get((e.state, e.features), set()) - {e.next_state}
    ]


class Taught:
    """An automaton that learns from examples that change."""

    def __init__(self, automaton: Automaton, examples: Sequence[Example], domain: Domain) -> None:
        self._automaton = automaton
        self.scales: list[Scale] = [
            BOOLEAN_SCALE if feature.name in FLAGS else domain.scale_of(feature)
            for feature in automaton.features
        ]
        self.names = [str(feature) for feature in automaton.features]
        self.examples = list(examples)
        self._labels = [START, *automaton.labels]
        self.learn()

    def learn(self) -> None:
        """Learn from the examples that there are now."""
        index = {label: i for i, label in enumerate(self._labels)}
        self._functions = learn_transitions(in_force(self.examples), self.scales)
        self._decide = {
            state: function.compile(range(len(self.scales)), index)
            for state, function in self._functions.items()
        }

    def decide(self, state: str, features: tuple[float, ...], draw: Callable[[], float]) -> str:
        """Return the next state; without examples that is the same."""
        decide = self._decide.get(state)
        if decide is None:
            return state
        return self._labels[decide(list(features), features.__getitem__, draw)]

    def automaton(self) -> Automaton:
        """Return it as it is now."""
        return replace(self._automaton, examples=tuple(self.examples), transitions=self._functions)


@dataclass(frozen=True)
class Watched:
    """A transition function that somebody decides."""

    automaton: str
    state: str
    features_used: tuple[int, ...]
    watch: Watch

    def compile(
        self, slots: Sequence[int], states: Mapping[str, int], *, most_probable: bool = False
    ) -> Decide:
        """Return the decision; it reads all features."""

        def decide(values: Values, read: Callable[[int], float], draw: Callable[[], float]) -> int:
            seen = [read(slot) if values[slot] is None else values[slot] for slot in slots]
            features = tuple(float(value) for value in seen if value is not None)
            return states[self.watch(self.automaton, self.state, features, draw)]

        return decide


def watched(automata: Mapping[str, Automaton], watch: Watch) -> dict[str, Automaton]:
    """Return automata whose decisions somebody makes."""
    return {
        name: replace(
            automaton,
            examples=(),
            transitions={
                state: Watched(name, state, tuple(range(len(automaton.features))), watch)
                for state in (START, *automaton.labels)
            },
        )
        for name, automaton in automata.items()
    }


def keeps_on(state: str, domain: Domain) -> bool:
    """Return whether commanding a state records a default example."""
    behavior = domain.behaviors.get(Use.parse(state).name)
    return state not in FLAGS and not (behavior is not None and behavior.one_shot)


def mistaken(
    automata: Mapping[str, Automaton], domain: Domain, rate: float, random: Random
) -> tuple[dict[str, list[Example]], set[tuple[str, int]]]:
    """Return the examples with wrong commands, and which (automaton, command) these are."""
    commands = [
        (name, command)
        for name, automaton in sorted(automata.items())
        for command in sorted({example.command for example in automaton.examples})
    ]
    wrong = set(random.sample(commands, round(rate * len(commands))))
    told: dict[str, list[Example]] = {}
    for name, automaton in automata.items():
        told[name] = []
        went: dict[int, str] = {}
        for e in automaton.examples:
            if (name, e.command) not in wrong:
                told[name].append(e)
            elif not e.is_default:
                others = [label for label in automaton.labels if label != e.next_state]
                went[e.command] = random.choice(others)
                told[name].append(replace(e, next_state=went[e.command]))
            elif keeps_on(went[e.command], domain):
                to = went[e.command]
                told[name].append(replace(e, state=to, next_state=to))
    return told, wrong


@dataclass
class Person:
    """Watches a keeper and corrects it.

    Attributes:
        meant: the automata taught without mistakes.
        taught: those that are corrected.
        accepts: whether proposals are accepted.
        told: the corrections of each automaton.
        removed: commands that were removed, as (automaton, command).
    """

    domain: Domain
    meant: dict[str, Taught]
    taught: dict[str, Taught]
    accepts: bool
    most: int
    told: dict[str, list[Correction]] = field(default_factory=dict)
    removed: set[tuple[str, int]] = field(default_factory=set)
    count: int = 0

    def watch(
        self, name: str, state: str, features: tuple[float, ...], draw: Callable[[], float]
    ) -> str:
        """Return what was meant; correct what the keeper would do instead."""
        right = self.meant[name].decide(state, features, draw)
        does = self.taught[name].decide(state, features, draw)
        if does != right and self.count < self.most:
            self._correct(name, Correction(state, features, does, right))
        return right

    def _correct(self, name: str, correction: Correction) -> None:
        self.count += 1
        taught = self.taught[name]
        number, command = CORRECTED + 2 * self.count, CORRECTED + self.count
        state, features, right = correction.state, correction.features, correction.right
        ordinary = Example(state, features, right, ExampleKind.CORRECTION, number, command)
        taught.examples.append(ordinary)
        if right != state and keeps_on(right, self.domain):
            taught.examples.append(
                Example(right, features, right, ExampleKind.DEFAULT, number + 1, command)
            )
        told = self.told.setdefault(name, [])
        told.append(replace(correction, number=number))
        if self.accepts:
            for proposal in propose(taught.examples, taught.scales, told, names=taught.names):
                if proposal.kind is ProposalKind.MISTAKE:
                    gone = [e for e in taught.examples if e.number in proposal.examples]
                    taught.examples = [e for e in taught.examples if e not in gone]
                    self.removed |= {(name, e.command) for e in gone if e.command}
        taught.learn()

    def train(self, automata: Mapping[str, Automaton], seed: int) -> None:
        """Watch until content."""
        world = KeepawayWorld(PAPER, seed)
        own = Repertoire(self.domain, watched(automata, self.watch))
        others = Repertoire(self.domain, automata)
        players = {
            name: AutomatonPlayer(others if i else own, Use(TOP), name)
            for i, name in enumerate(world.agents)
        }
        content = 0
        for episode in range(EPISODES):
            before = self.count
            play(world, players, 1, first=episode, cycles_max=LONGEST)
            content = content + 1 if self.count == before else 0
            if content == CONTENT:
                break


def situations(
    automata: Mapping[str, Automaton], meant: Mapping[str, Taught], domain: Domain, episodes: int
) -> dict[Situation, int]:
    """Return how often the automata get into each situation."""
    seen: dict[Situation, int] = {}

    def watch(
        name: str, state: str, features: tuple[float, ...], draw: Callable[[], float]
    ) -> str:
        seen[name, state, features] = seen.get((name, state, features), 0) + 1
        return meant[name].decide(state, features, draw)

    world = KeepawayWorld(PAPER, seed=9999)
    own = Repertoire(domain, watched(automata, watch))
    play(world, perform(world, own, TOP), episodes, cycles_max=LONGEST)
    return seen


def agreement(
    meant: Mapping[str, Taught], taught: Mapping[str, Taught], seen: Mapping[Situation, int]
) -> tuple[float, float]:
    """Return the agreement over all situations, and over those in which the state changes."""
    random = Random(1)
    agreed, total = [0, 0], [0, 0]
    for (name, state, features), times in seen.items():
        right = meant[name].decide(state, features, random.random)
        same = taught[name].decide(state, features, random.random) == right
        for i in range(1 + (right != state)):
            agreed[i] += times * same
            total[i] += times
    return agreed[0] / total[0], agreed[1] / total[1]


def hold_times(taught: Mapping[str, Taught], domain: Domain, episodes: int) -> list[float]:
    """Return how long three keepers hold the ball that all perform the automata, s."""
    automata = {name: t.automaton() for name, t in taught.items()}
    world = KeepawayWorld(PAPER, seed=4242)
    players = perform(world, Repertoire(domain, automata), TOP)
    return [p.seconds for p in play(world, players, episodes, first=0, cycles_max=36_000)]


def main(
    seeds: Annotated[int, typer.Option(help="How many seeds.", min=2)] = 20,
    first: Annotated[int, typer.Option(help="The first seed.")] = 100,
    most: Annotated[int, typer.Option(help="The most corrections of a person.", min=1)] = 40,
    episodes: Annotated[int, typer.Option(help="For each hold time; 0: none.", min=0)] = 10,
    quick: Annotated[bool, typer.Option(help="3 seeds, no hold times.")] = False,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Measure the recovery from mistaken commands, with and without unlearning."""
    seeds, episodes = (3, 0) if quick else (seeds, episodes)
    opened = open_library(shipped("libraries", "keepaway"))
    domain, automata = opened.domain, dict(opened.load())
    meant = {name: Taught(a, a.examples, domain) for name, a in automata.items()}
    seen = situations(automata, meant, domain, episodes=6)
    written: dict[str, Any] = {"seeds": seeds, "first": first, "rates": {}}
    if episodes:
        times = hold_times(meant, domain, episodes * seeds)
        error = stdev(times) / len(times) ** 0.5
        print(f"taught without mistakes: hold time {fmean(times):.2f} ± {error:.2f} s", flush=True)
        written["clean_hold_time_s"] = {"mean": fmean(times), "se": error}
    for rate in RATES:
        rows: dict[str, list[dict[str, float]]] = {}
        for seed in range(first, first + seeds):
            told, wrong = mistaken(automata, domain, rate, Random(seed))
            spotless = {
                name: [e for e in examples if (name, e.command) not in wrong]
                for name, examples in told.items()
            }
            for case, examples, accepts in (
                ("before", told, None),
                ("corrected", told, False),
                ("unlearned", told, True),
                ("spotless", spotless, False),
            ):
                taught = {n: Taught(automata[n], examples[n], domain) for n in automata}
                person = Person(domain, meant, taught, bool(accepts), most)
                if accepts is not None:
                    person.train(automata, seed)
                overall, changing = agreement(meant, taught, seen)
                own = {removed for removed in person.removed if removed[1] < CORRECTED}
                rows.setdefault(case, []).append(
                    {
                        "agreement": overall,
                        "agreement_changing": changing,
                        "corrections": person.count,
                        "found": len(own & wrong) / len(wrong),
                        "lost": len(own - wrong),
                        "hold_time_s": fmean(hold_times(taught, domain, episodes))
                        if episodes
                        else 0.0,
                    }
                )
            print(f"  seed {seed}, {rate:.0%}: done", flush=True)
        print(f"{rate:.0%} of the commands mistaken")
        written["rates"][str(rate)] = {}
        for case, its in rows.items():
            means = {key: fmean(row[key] for row in its) for key in its[0]}
            errors = {key: stdev(row[key] for row in its) / len(its) ** 0.5 for key in its[0]}
            lost = median(row["lost"] for row in its)
            written["rates"][str(rate)][case] = {
                key: {"mean": means[key], "se": errors[key]} for key in means
            } | {"lost_median": lost}
            print(
                f"  {case:10} agreement {means['agreement']:.4f} ± {errors['agreement']:.4f}, "
                f"changing state {means['agreement_changing']:.3f}; "
                f"{means['corrections']:.1f} corrections; noise found {means['found']:.0%}, "
                f"clean lost {means['lost']:.2f} (median {lost:g})"
                + (
                    f"; holds {means['hold_time_s']:.1f} ± {errors['hold_time_s']:.1f} s"
                    if episodes
                    else ""
                )
            )
    if json:
        Path(json).write_text(js.dumps(written, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
