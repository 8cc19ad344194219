"""Sequences of percepts for an exported behavior, and what the engine makes of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from random import Random
from typing import Any

from hitab_core import Automaton, Domain, Repertoire, Target, Term
from hitab_core.running import (
    Change,
    FeatureCache,
    RunContext,
    RunningAutomaton,
    performance,
)
from hitab_export.hierarchy_form import INTERNAL, Hierarchy, TestForm

Percept = Mapping[str, float]
Step = tuple[Percept, float, bool]
"""Feature values by name, NaN if missing, the time, and whether to begin anew."""

Acts = list[str]
"""What happens to the robot in a tick, such as ``["stop GoFast", "start Pass", "pulse Pass"]``."""

Seen = tuple[list[str], Acts]
"""The active states after a tick, and what happened."""

Taken = tuple[str, str, str]
"""A transition: automaton, source, destination."""


class _Body:
    def __init__(self) -> None:
        self.percept: Percept = {}
        self.acts: Acts = []


def recorded_domain(domain: Domain) -> Domain:
    """Return a domain whose bodies read a percept by names, and note what is done."""

    def reading(name: str) -> Callable[..., float]:
        return lambda body, *targets: body.percept[str(Term(name, targets))]

    def noting(what: str, name: str) -> Callable[..., None]:
        return lambda body, *targets: body.acts.append(f"{what} {Term(name, targets)}")

    return replace(
        domain,
        body=lambda name: _Body(),
        targets={n: Target(n, lambda body, name=n: name) for n in domain.targets},
        features={n: replace(f, read=reading(n)) for n, f in domain.features.items()},
        behaviors={
            n: replace(b, **{what: noting(what, n) for what in ("start", "pulse", "stop")})
            for n, b in domain.behaviors.items()
        },
    )


@dataclass
class Replayed:
    """What the engine did: each tick, and the transitions that were taken."""

    seen: list[Seen]
    taken: set[Taken]


def replayed(
    domain: Domain,
    automata: Mapping[str, Automaton],
    term: Term,
    steps: Sequence[Step],
    draw: Callable[[], float],
) -> Replayed:
    """Return what the engine makes of percepts."""
    taken: set[Taken] = set()
    domain = recorded_domain(domain)
    repertoire = Repertoire(domain, automata)
    body = domain.body("robot")
    feature_cache = FeatureCache(body, domain)

    def observe(change: Change) -> None:
        taken.add((path_of(running, change), change.source, change.destination))

    context = RunContext(repertoire, body, feature_cache, draw, observe=observe)
    running = performance(context, term)
    assert isinstance(running, RunningAutomaton)
    seen: list[Seen] = []
    for percept, now, begins in steps:
        context.clock.now = now
        body.percept, body.acts = percept, []
        if begins:
            running.stop()
            running.start()
        feature_cache.forget()
        running.tick()
        seen.append((running.active_path, body.acts))
    return Replayed(seen, taken)


def path_of(running: RunningAutomaton, change: Change) -> str:
    """Return the bound automaton that changes; labels alone are in their users' own terms."""
    level = running
    for _ in change.automata[1:]:
        child = level.child
        assert isinstance(child, RunningAutomaton)
        level = child
    return str(Term(level.automaton.name, tuple(level.bindings.values())))


def all_transitions(hierarchy: Hierarchy) -> set[Taken]:
    """Return every transition that a leaf of a tree can lead to."""
    return {
        (str(automaton.term), state.label, automaton.states[to].label)
        for automaton in hierarchy.automata
        for index, state in enumerate(automaton.states)
        for leaf in state.tree or ()
        if not isinstance(leaf, TestForm)
        for _, to in leaf.chances
        if to != index
    }


def steered_steps(hierarchy: Hierarchy, count: int, seed: str) -> list[Step]:
    """Return random percepts: at the boundaries of the trees, beside them, anywhere, missing."""
    random = Random(seed)
    numbers: dict[int, list[float]] = {}
    for automaton in hierarchy.automata:
        for state in automaton.states:
            for node in state.tree or ():
                if isinstance(node, TestForm):
                    numbers.setdefault(node.feature, []).extend((node.low, node.high))
    choices: dict[str, list[float]] = {}
    for index, feature in enumerate(hierarchy.features, len(INTERNAL)):
        ends = sorted({n for n in numbers[index] if math.isfinite(n)})
        if feature.categories > 0:
            values = [float(category) for category in range(feature.categories)]
        else:
            values = [v for n in ends for v in (n, *(math.nextafter(n, d) for d in (-9e9, 9e9)))]
            values += [n + d for n in ends for d in (-1.0, 1.0)] + [0.0, 1.0]
            values += [v - feature.period for v in values if feature.period]
        choices[feature.label] = values if feature.required else [*values, math.nan]
    percept = {label: random.choice(values) for label, values in choices.items()}
    steps, now = [], 100.0
    for _ in range(count):
        for label, values in choices.items():
            if random.random() < 0.3:
                percept[label] = random.choice(values)
        now += random.choice((0.1, 0.1, 0.1, 1.0))
        steps.append((dict(percept), now, not steps or random.random() < 0.05))
    return steps


def recorded_steps(hierarchy: Hierarchy, domain: Domain, world: Any, players: Any) -> list[Step]:
    """Return what the first agent of a world perceives in episodes that its players play."""
    name = next(iter(players))
    player = players[name]
    feature_cache = FeatureCache(player.body, domain)
    terms = [Term.parse(feature.label) for feature in hierarchy.features]
    steps: list[Step] = []
    tick = player.tick

    def noted() -> None:
        values = {str(term): _value(feature_cache, term) for term in terms}
        steps.append((values, 0.1 * len(steps), world.episode_cycle == 0 or not steps))
        tick()

    player.tick = noted
    return steps


def _value(feature_cache: FeatureCache, term: Term) -> float:
    try:
        return feature_cache.look(term)
    except Exception:
        return math.nan


def draws(seed: str) -> Iterator[float]:
    """Yield random numbers."""
    random = Random(seed)
    while True:
        yield random.random()
