from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.learning.trimming import rebind, trim
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.repertoire import Repertoire
from hitab_core.term import Term
from hitab_core.texts.errors import VocabularyError

Teach = Callable[..., Automaton]


@pytest.fixture(scope="module")
def repertoire(robot: Domain, approach: Automaton) -> Repertoire:
    return Repertoire(robot, {"Approach": approach})


def names(automaton: Automaton) -> list[str]:
    return [str(feature) for feature in automaton.features]


def drawn(automaton: Automaton) -> dict[str, str]:
    """Return the automaton's trees in words."""
    return {
        state: function.as_text(names(automaton))  # type: ignore[attr-defined]
        for state, function in automaton.transitions.items()
    }


def test_states_never_visited_and_features_never_used_are_trimmed(
    repertoire: Repertoire, teach: Teach
) -> None:
    automaton = teach(
        "Fetch",
        ["Role", "DistanceTo(ball)", "BallIsKickable"],
        [("Start", [0, 9.5, 0], "GoFast"), ("GoFast", [0, 0.5, 0], "Stop")],
        states=["Kick", "GoTo(goal)"],
    )
    trimmed, notes = trim(automaton, repertoire)
    assert trimmed.labels == ("GoFast", "Stop")
    assert names(trimmed) == ["DistanceTo(ball)"]
    assert [example.features for example in trimmed.examples] == [(9.5,), (9.5,), (0.5,), (0.5,)]
    assert drawn(trimmed) == drawn(automaton)
    assert notes == [
        'state "Kick" was never visited',
        'state "GoTo(goal)" was never visited',
        'feature "Role" is not used by any transition function',
        'feature "BallIsKickable" is not used by any transition function',
    ]


def test_a_required_feature_stays_though_nothing_tests_it(robot: Domain, teach: Teach) -> None:
    kickable = replace(robot.features["BallIsKickable"], required=True)
    careful = replace(robot, features={**robot.features, "BallIsKickable": kickable})
    rows = [("Start", [0, 9.5, 0], "GoFast"), ("GoFast", [0, 0.5, 0], "Stop")]
    features = ["Role", "DistanceTo(ball)", "BallIsKickable"]
    trimmed, notes = trim(teach("Fetch", features, rows), Repertoire(careful))
    assert names(trimmed) == ["DistanceTo(ball)", "BallIsKickable"]
    assert notes == ['feature "Role" is not used by any transition function']


def test_a_feature_stays_if_another_tree_would_grow_without_it(
    repertoire: Repertoire, teach: Teach
) -> None:
    # C4.5 compares the gain of a split with the average over all features: "Done" is not used,
    # but it lowers the average so that "BallIsKickable" is worth considering.
    values = [(1, 0, 1), (2, 0, 0), (0, 0, 1), (1, 0, 0), (1, 1, 0)]
    to = ["GoFast", "GoSlow", "GoFast", "GoFast", "Stop"]
    features = ["Role", "BallIsKickable", "Done"]
    rows = [("Start", seen, state) for seen, state in zip(values, to, strict=True)]
    automaton = teach("Odd", features, rows, defaults=False)
    without = teach("Odd", features[:2], [(s, seen[:2], n) for s, seen, n in rows], defaults=False)
    assert drawn(without) != drawn(automaton)
    trimmed, notes = trim(automaton, repertoire)
    assert drawn(trimmed) == drawn(automaton)
    assert names(trimmed) == features
    assert notes == [
        'kept feature "Done": no transition function uses it, but without it the learned '
        "functions would differ"
    ]


@given(data=st.data())
@settings(max_examples=60)
def test_a_trimmed_automaton_decides_as_before(
    data: st.DataObject, repertoire: Repertoire, teach: Teach
) -> None:
    values = st.tuples(
        st.integers(0, 2), st.integers(0, 1), st.floats(0, 360), st.floats(0, 3), st.integers(0, 1)
    )
    state = st.sampled_from(["GoFast", "GoSlow", "Stop"])
    rows = data.draw(
        st.lists(st.tuples(st.just("Start") | state, values, state), min_size=1, max_size=10)
    )
    features = ["Role", "BallIsKickable", "DirectionTo(goal)", "DistanceTo(ball)", "Done"]
    automaton = teach("Any", features, rows)
    trimmed, _ = trim(automaton, repertoire)
    kept = [features.index(name) for name in names(trimmed)]
    for seen in data.draw(st.lists(values, min_size=1, max_size=10)):
        row = [float(value) for value in seen]
        for label, function in automaton.transitions.items():
            before = function.explain(row, features)
            after = trimmed.transitions[label].explain([row[i] for i in kept], names(trimmed))
            assert after.distribution == before.distribution
            assert after.tests == before.tests


def test_a_target_can_become_a_parameter(repertoire: Repertoire, teach: Teach) -> None:
    automaton = teach(
        "Visit",
        ["DistanceTo(ball)"],
        [("Start", [9.0], "GoTo(ball)"), ("GoTo(ball)", [1.0], "Done")],
    )
    visit = rebind(automaton, {"ball": "A"}, repertoire)
    assert visit.parameters == ("A",)
    assert visit.labels == ("GoTo(A)", "Done")
    assert names(visit) == ["DistanceTo(A)"]
    assert [(e.state, e.next_state) for e in visit.examples] == [
        ("Start", "GoTo(A)"),
        ("GoTo(A)", "GoTo(A)"),
        ("GoTo(A)", "Done"),
    ]
    assert list(visit.transitions) == ["Start", "GoTo(A)"]
    assert [e.features for e in visit.examples] == [e.features for e in automaton.examples]


def test_a_generalized_behavior_is_used_twice_with_different_targets(
    repertoire: Repertoire, teach: Teach, robot: Domain, tmp_path: Path
) -> None:
    visit = rebind(
        teach(
            "Visit",
            ["DistanceTo(ball)"],
            [("Start", [9.0], "GoTo(ball)"), ("GoTo(ball)", [1.0], "Done")],
        ),
        {"ball": "A"},
        repertoire,
    )
    library = BehaviorLibrary(tmp_path, robot)
    library.save(trim(visit, repertoire)[0])
    library.save(
        teach(
            "Shuttle",
            ["Done"],
            [
                ("Start", [0], "Visit(ball)"),
                ("Visit(ball)", [1], "Visit(goal)"),
                ("Visit(goal)", [1], "Visit(ball)"),
            ],
        )
    )
    trained = BehaviorLibrary(tmp_path, robot).load()
    assert trained["Visit"].parameters == ("A",)
    assert trained["Shuttle"].labels == ("Visit(ball)", "Visit(goal)")


def test_one_place_alone_can_be_rebound(repertoire: Repertoire, teach: Teach) -> None:
    automaton = teach(
        "Visit", ["DistanceTo(ball)"], [("Start", [9.0], "GoTo(ball)"), ("Start", [2.0], "Stop")]
    )
    bound = rebind(automaton, {"DistanceTo(ball)": "DistanceTo(B)"}, repertoire)
    assert bound.labels == ("GoTo(ball)", "Stop")
    assert names(bound) == ["DistanceTo(B)"]
    assert bound.parameters == ("B",)
    with pytest.raises(VocabularyError, match="only its targets can be bound"):
        rebind(automaton, {"DistanceTo(ball)": "DirectionTo(goal)"}, repertoire)


@pytest.mark.parametrize(
    ("bindings", "complaint"),
    [
        ({"bal": "A"}, r'"bal" is not in automaton "Both" \(known: '),
        ({"ball": "not a name"}, '"not a name" cannot be a target or parameter'),
        ({"ball": "goal"}, r'states "GoTo\(ball\)" and "GoTo\(goal\)" would both become'),
    ],
)
def test_bindings_that_make_no_sense_are_refused(
    repertoire: Repertoire, teach: Teach, bindings: dict[str, str], complaint: str
) -> None:
    automaton = teach(
        "Both", ["BallIsKickable"], [("Start", [0], "GoTo(ball)"), ("Start", [1], "GoTo(goal)")]
    )
    with pytest.raises(VocabularyError, match=complaint):
        rebind(automaton, bindings, repertoire)


def test_what_is_unbound_is_refused_by_name(repertoire: Repertoire, approach: Automaton) -> None:
    unbound = replace(approach, features=(Term("DistanceTo", ("X",)),))
    with pytest.raises(VocabularyError) as refused:
        trim(unbound, repertoire)
    assert str(refused.value) == (
        '"X" in "DistanceTo(X)" of automaton "Approach" is unbound; bind it to a target, or make '
        "it a parameter (known: ball, goal)"
    )
