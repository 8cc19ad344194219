"""A library of everything that a behavior may consist of, taught at random, with awkward names."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from random import Random

from hitab_core import (
    START,
    Automaton,
    BasicBehavior,
    BehaviorLibrary,
    Domain,
    Example,
    Feature,
    FeatureKind,
    Target,
    Term,
)
from hitab_core.learning import learn_transitions

VALUES = {
    "Done": (0.0, 1.0),
    "Failed": (0.0, 1.0),
    "SecondsInState": (0.1, 0.2, 0.5, 1.0, 2.0),
    "SecondsSince": (0.1, 0.2, 0.5, 1.0, 2.0),
    "double": (-1e-300, 0.1, -0.3, 1e17),
    "D": (1.0, 2.5, -3.0, math.nan),
    "Angle": (-170.0, -1e-20, 0.0, 90.0, 350.0, math.nan),
    "Role": (0.0, 1.0, 3.0, math.nan),
    "Lit": (0.0, 1.0),
}


def _read(body: object, *targets: object) -> float:
    return 0.0


def odd_domain() -> Domain:
    """Return a domain whose names are keywords, or the same once they are identifiers."""
    return Domain.of(
        "odd",
        "1",
        lambda name: None,
        behaviors=[
            BasicBehavior("Sleep"),
            BasicBehavior("class"),
            BasicBehavior("Go", parameters=("thing", "other")),
            BasicBehavior("Pass", one_shot=True),
        ],
        features=[
            Feature("double", _read, required=True),
            Feature("D", _read, parameters=("x", "y")),
            Feature("Angle", _read, FeatureKind.TOROIDAL, period=360.0),
            Feature("Role", _read, FeatureKind.CATEGORICAL, categories=("w", "x", "y", "z")),
            Feature("Lit", _read, FeatureKind.BOOLEAN, required=True),
        ],
        targets=[Target(name, lambda body: 0) for name in ("a", "a_b", "b_c", "c")],
    )


def odd_library(folder: Path) -> BehaviorLibrary:
    """Return a library of three levels: Behavior is made of Middle and Inner, Middle of Inner."""
    random, library = Random(5), BehaviorLibrary(folder, odd_domain())

    def teach(name: str, states: Sequence[str], features: Sequence[str], *parameters: str) -> None:
        terms = tuple(map(Term.parse, features))
        examples: list[Example] = []
        for state in (START, *(state for state in states if state not in ("Done", "Failed"))):
            for _ in range(14):
                values = tuple(random.choice(VALUES[term.name]) for term in terms)
                number = len(examples) + 1
                following = random.choice(states)
                examples.append(Example(state, values, following, number=number, command=number))
        learned = learn_transitions(examples, [library.domain.scale_of(term) for term in terms])
        states_used = tuple(map(Term.parse, states))
        library.save(Automaton(name, states_used, terms, learned, parameters, tuple(examples)))

    teach("Inner", ["Go(A, c)", "Sleep", "Done", "Failed"], ["D(A, c)", "SecondsInState"], "A")
    teach(
        "Middle",
        ["Inner(a)", "Inner(b_c)", "class", "Done", "Pass"],
        ["Done", "Failed", "Role", "Angle", "SecondsSince(Done)", "SecondsSince(Failed)"],
    )
    teach(
        "Behavior",
        ["Middle", "Inner(a_b)", "Go(a_b, c)", "Go(a, b_c)", "Failed"],
        ["Failed", "double", "Lit", "D(a_b, c)", "D(a, b_c)", "SecondsInState"],
    )
    return library
