"""A small robot, and automata taught to it, for the tests of what is stored and drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature, FeatureKind, Target
from hitab_core.example import Example, ExampleKind
from hitab_core.learning.transition_learning import learn_transitions
from hitab_core.term import Term

Row = tuple[str, Sequence[float], str]
Teach = Callable[..., Automaton]


def _nothing(body: object, *targets: object) -> float:
    return 0.0


@pytest.fixture(scope="session")
def robot() -> Domain:
    """Return a domain with features of every kind."""
    return Domain.of(
        "small_robot",
        "1",
        lambda name: None,
        behaviors=[
            BasicBehavior("GoFast"),
            BasicBehavior("GoSlow"),
            BasicBehavior("GoTo", parameters=("place",)),
            BasicBehavior("Stop"),
            BasicBehavior("Kick", one_shot=True),
        ],
        features=[
            Feature("DistanceTo", _nothing, parameters=("thing",), unit="m"),
            Feature(
                "DirectionTo", _nothing, FeatureKind.TOROIDAL, ("thing",), "deg", period=360.0
            ),
            Feature("BallIsKickable", _nothing, FeatureKind.BOOLEAN),
            Feature(
                "Role", _nothing, FeatureKind.CATEGORICAL, categories=("keeper", "taker", "off")
            ),
        ],
        targets=[Target("ball", lambda body: 0), Target("goal", lambda body: 1)],
        automata=[
            Automaton("Patrol", (Term("GoSlow"),), (), {}, description="written by hand"),
        ],
    )


@pytest.fixture(scope="session")
def teach(robot: Domain) -> Teach:
    """Return what makes an automaton of examples: (state, feature values, next state)."""

    def taught(
        name: str,
        features: Sequence[str],
        rows: Sequence[Row],
        *,
        parameters: Sequence[str] = (),
        states: Sequence[str] = (),
        classifier: str = "tree",
        defaults: bool = True,
        domain: Domain | None = None,
    ) -> Automaton:
        examples: list[Example] = []
        for command, (state, values, next_state) in enumerate(rows, 1):
            seen = tuple(float(value) for value in values)
            shown = Example(
                state,
                seen,
                next_state,
                number=len(examples) + 1,
                command=command,
                cycle=10 * command,
            )
            examples.append(shown)
            if defaults and state != next_state and next_state not in (*FLAGS, "Kick"):
                examples.append(
                    replace(
                        shown, state=next_state, kind=ExampleKind.DEFAULT, number=len(examples) + 1
                    )
                )
        mentioned = [label for e in examples for label in (e.state, e.next_state)]
        labels = [label for label in dict.fromkeys([*mentioned, *states]) if label != START]
        terms = tuple(Term.parse(feature) for feature in features)
        scales = [(domain or robot).scale_of(term) for term in terms]
        return Automaton(
            name,
            tuple(Term.parse(label) for label in labels),
            terms,
            learn_transitions(examples, scales, classifier),
            tuple(parameters),
            tuple(examples),
        )

    return taught


@pytest.fixture(scope="session")
def approach(teach: Teach) -> Automaton:
    """Return an automaton of basic behaviors alone."""
    return teach(
        "Approach",
        ["DistanceTo(ball)"],
        [
            ("Start", [20.25], "GoFast"),
            ("GoFast", [4.5], "GoSlow"),
            ("GoSlow", [0.3], "Stop"),
            ("Stop", [7.1], "GoFast"),
        ],
    )


@pytest.fixture(scope="session")
def control(teach: Teach) -> Automaton:
    """Return an automaton that uses `approach` and has features of all kinds."""
    return teach(
        "Control",
        ["DistanceTo(ball)", "DirectionTo(goal)", "BallIsKickable", "Role"],
        [
            ("Start", [12.345678901234567, 350.0, 0, 0], "Approach"),
            ("Approach", [0.1, 10.0, 1, 0], "Kick"),
            ("Kick", [1e-7, 0.1, 0, 2], "Done"),
            ("Kick", [1e22, -3.25, 1, 2], "GoTo(goal)"),
        ],
    )


@pytest.fixture(scope="session")
def keepaway(teach: Teach) -> Automaton:
    """Return an automaton that uses `control`."""
    return teach(
        "Keepaway",
        ["BallIsKickable", "Done"],
        [
            ("Start", [1, 0], "Control"),
            ("Control", [0, 1], "Stop"),
            ("Stop", [1, 0], "Control"),
            ("Control", [0, 0], "Control"),
        ],
    )
