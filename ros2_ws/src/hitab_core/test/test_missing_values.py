"""Missing values: C4.5's fractions of examples, in learning and in deciding."""

from __future__ import annotations

import math
import random
from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_core.automaton import START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature, FeatureKind, Scale
from hitab_core.learning.boundaries import on_circle
from hitab_core.learning.gain_ratio import gain_and_ratio, two_way_gains
from hitab_core.learning.transition_learning import learner
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_growth import LEAST_FRACTION
from hitab_core.learning.tree_nodes import Fork, Leaf, Threshold, nodes
from hitab_core.learning.tree_pruning import pessimistic_errors
from hitab_core.repertoire import Repertoire
from hitab_core.running import RunContext, performance
from hitab_core.running.feature_cache import FeatureCache
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, NoValueError
from hitab_core.transition_function import HandWritten

NAN = math.nan
CONTINUOUS = Scale()
MIXED = [
    CONTINUOUS,
    Scale(FeatureKind.TOROIDAL, 360.0),
    Scale(FeatureKind.BOOLEAN),
    Scale(FeatureKind.CATEGORICAL, 0.0, ("a", "b", "c", "d")),
]
NAMES = ["x", "angle", "lit", "kind"]
STATES = {"C": 0, "A": 1, "B": 2}
PATCHY = st.tuples(
    st.sampled_from([NAN, -1.0, 0.0, 2.0]),
    st.sampled_from([NAN, -170.0, -1e-20, 0.0, 90.0, 350.0]),
    st.sampled_from([NAN, 0.0, 1.0]),
    st.sampled_from([NAN, 0.0, 1.0, 2.0, 3.0]),
)
TAUGHT = st.lists(st.tuples(PATCHY, st.sampled_from("ABC")), min_size=1, max_size=12)


def learn_transition(classifier, scales, X, y, default=None, names=None):
    """Learn the transition function of one state; by default no example is a default one."""
    return learner(classifier, scales, names)(X, y, default or [False] * len(y))


def learned(rows: Any, labels: Any, scales: Any = MIXED, **parameters: Any) -> TransitionTree:
    return TransitionTree(scales, **parameters).fit(rows, labels)


# Gain ------------------------------------------------------------------------------------------


def test_gain_and_ratio_are_those_of_quinlans_weather_example_with_one_outlook_unknown() -> None:
    # C4.5, section 3.1.2: outlook of 13 of 14 cases, by Play and Don't play.
    gain, ratio = gain_and_ratio(np.array([[2, 3], [3, 0], [3, 2]]), 1)
    assert gain == pytest.approx(0.199, abs=6e-4)
    assert gain / ratio == pytest.approx(1.809, abs=6e-4)


@given(
    st.lists(st.tuples(*[st.integers(0, 9)] * 3), min_size=2, max_size=4).filter(
        lambda counts: any(map(sum, counts))
    ),
    st.integers(0, 9),
)
def test_gain_and_ratio_are_those_of_quinlans_formulas_however_many_are_unknown(
    counts: Any, unknown: int
) -> None:
    def bits(sizes: Any) -> float:
        return -sum(n / sum(sizes) * math.log2(n / sum(sizes)) for n in sizes if n)

    sizes = [sum(branch) for branch in counts]
    known, everybody = sum(sizes), sum(sizes) + unknown
    left = sum(n / known * bits(branch) for n, branch in zip(sizes, counts, strict=True) if n)
    gain = known / everybody * (bits([*map(sum, zip(*counts, strict=True))]) - left)
    split = bits([*sizes, unknown])
    expected = gain, gain / split if split else 0.0
    assert gain_and_ratio(np.array(counts), unknown) == pytest.approx(expected, abs=1e-9)


@given(st.lists(st.tuples(*[st.integers(0, 9)] * 3), min_size=2, max_size=4))
def test_whole_numbers_gain_the_same_whatever_their_type(counts: Any) -> None:
    whole = np.array(counts)
    if not whole.sum():
        return
    assert gain_and_ratio(whole) == pytest.approx(gain_and_ratio(whole.astype(float)))
    gains = [two_way_gains(n.T, n.sum(axis=0), 1)[0] for n in (whole, whole.astype(float))]
    assert gains[0] == pytest.approx(gains[1])


# Learning --------------------------------------------------------------------------------------


def test_an_example_without_a_value_goes_into_each_branch_in_part() -> None:
    tree = learned([[1], [2], [9], [NAN]], ["A", "A", "B", "B"], [CONTINUOUS])
    assert tree.root_ == Fork(
        0, Threshold(5.5), (2, 2), (Leaf((2.0, 2 / 3)), Leaf((0.0, 1 + 1 / 3)))
    )
    assert tree.as_text("x") == "x <= 5.5: A 0.75, B 0.25 (2.67)\nx > 5.5: B (1.33)"
    assert str(tree.rules("x")[0]) == "if x <= 5.5: A 0.75, B 0.25 (2.67 examples)"


@pytest.mark.parametrize("missing", [NAN, None])
def test_a_part_of_an_example_is_separated_by_other_features(missing: Any) -> None:
    tree = learned([[1, 1], [9, 1], [missing, 5]], ["A", "B", "A"], [CONTINUOUS] * 2)
    assert tree.predict([[1, 1], [9, 1], [9, 5], [missing, 5]]).tolist() == ["A", "B", "A", "A"]
    assert tree.predict_proba([[missing, 1], [missing, missing]]) == pytest.approx(
        np.array([[0.5, 0.5], [2 / 3, 1 / 3]])
    )


@settings(max_examples=60)
@given(TAUGHT)
def test_a_complete_example_that_nothing_contradicts_is_reproduced(taught: Any) -> None:
    rows, labels = zip(*taught, strict=True)
    tree = learned(rows, labels)
    place = [(v[0], on_circle(v[1], 360.0), *v[2:]) for v in rows]

    def may_be_the_same(one: Any, other: Any) -> bool:
        return all(a == b or a != a or b != b for a, b in zip(one, other, strict=True))

    for values, label, here in zip(rows, labels, place, strict=True):
        if any(v != v for v in here):
            continue
        others = zip(labels, place, strict=True)
        rivals = [other for other, there in others if may_be_the_same(here, there)]
        if set(rivals) == {label}:
            odds = dict(zip(tree.labels, tree.predict_proba([values])[0], strict=True))
            assert odds[label] == pytest.approx(1.0)


@settings(max_examples=60)
@given(TAUGHT, st.booleans())
def test_parts_add_up_to_the_examples_and_bound_the_tree(taught: Any, prune: bool) -> None:
    rows, labels = zip(*taught, strict=True)
    tree = learned(rows, labels, prune=prune)
    leaves = [node for node in nodes(tree.root_) if isinstance(node, Leaf)]
    for i, label in enumerate(tree.labels):
        assert sum(leaf.counts[i] for leaf in leaves) == pytest.approx(labels.count(label))
    assert len(leaves) <= len(rows) / LEAST_FRACTION
    assert tree.digest() == learned(rows, labels, prune=prune).digest()


def test_where_only_what_is_lacking_differs_nothing_is_tested() -> None:
    assert learned([[1], [2], [NAN]], ["A", "A", "B"], [CONTINUOUS]).root_ == Leaf((2, 1))
    assert learned([[NAN], [NAN]], ["A", "B"], [CONTINUOUS]).features_used == ()


def test_two_features_that_matter_only_together_are_tested_though_a_third_is_never_known() -> None:
    rows = [[a, b, NAN] for a in (0, 1) for b in (0, 1)]
    tree = learned(rows, ["A", "B", "B", "A"], [CONTINUOUS] * 3)
    assert tree.predict(rows).tolist() == ["A", "B", "B", "A"]


def test_many_missing_values_make_no_endless_tree() -> None:
    rng = random.Random(4)
    n, m = 24, 12
    rows = [[NAN] * m for _ in range(n)]
    for f in range(m):
        for i in rng.sample(range(n), 2):
            rows[i][f] = rng.random()
    labels = [rng.choice("AB") for _ in range(n)]
    tree = learned(rows, labels, [CONTINUOUS] * m)
    assert len(nodes(tree.root_)) < 2 * n / LEAST_FRACTION


def test_pessimistic_errors_of_parts_lie_between_those_of_whole_errors() -> None:
    none, half, one = (pessimistic_errors(e, 6.0, 0.25) for e in (0, 0.5, 1))
    assert half == pytest.approx((none + one) / 2)
    assert pessimistic_errors(1.2, 1.5, 0.25) == pytest.approx(1.2 + 0.67 * 0.3)  # stats.c


def test_the_digest_has_parts_exactly() -> None:
    rows = [[1], [2], [9], [NAN]]
    one = learned(rows, ["A", "A", "B", "B"], [CONTINUOUS])
    assert one.root_.branches[0].counts == (2.0, 2 / 3)
    assert one.root_.counts == (2, 2)
    assert one.digest() != learned([*rows, [NAN]], [*"AABBB"], [CONTINUOUS]).digest()


# Deciding --------------------------------------------------------------------------------------


def reading(values: Any) -> Any:
    """Return what reads missing values as an agent does."""

    def read(slot: int) -> float:
        if values[slot] != values[slot]:
            raise NoValueError("no value")
        return float(values[slot])

    return read


@settings(max_examples=60)
@given(TAUGHT, PATCHY, st.integers(0, 3))
def test_a_drawn_decision_has_the_distribution_that_is_predicted(
    taught: Any, asked: Any, depth: int
) -> None:
    tree = learned(*zip(*taught, strict=True), max_depth=depth)
    decide, names = tree.compile(range(4), STATES), list(STATES)
    odds = dict(zip(tree.labels, tree.predict_proba([asked])[0].tolist(), strict=True))
    n = 600
    drawn = Counter(
        names[decide([None] * 4, reading(asked), lambda i=i: (i + 0.5) / n)] for i in range(n)
    )
    for label in tree.labels:
        # Each leaf takes part of the draws, in one piece.
        assert abs(drawn[label] / n - odds[label]) <= len(nodes(tree.root_)) / n
    expected = {label: p for label, p in odds.items() if p > 0}
    assert tree.explain(asked, NAMES).distribution == pytest.approx(expected)


@given(TAUGHT, PATCHY, st.integers(0, 3))
def test_without_draws_the_most_probable_state_is_taken_whatever_is_missing(
    taught: Any, asked: Any, depth: int
) -> None:
    tree = learned(*zip(*taught, strict=True), max_depth=depth)
    odds = dict(zip(tree.labels, tree.predict_proba([asked])[0].tolist(), strict=True))
    names = list(STATES)
    decide = tree.compile(range(4), STATES, most_probable=True)
    chosen = names[decide([None] * 4, reading(asked), None)]
    assert names[decide(list(asked), reading(asked), None)] == chosen
    assert odds[chosen] == pytest.approx(max(odds.values()))
    assert all(STATES[chosen] <= STATES[label] for label in odds if odds[label] == odds[chosen])


def test_a_decision_takes_one_draw_and_what_is_left_of_it_serves_on() -> None:
    tree = learned([[1, 1], [1, 5], [9, 1], [9, 1]], ["A", "B", "C", "C"], [CONTINUOUS] * 2)
    draws = []

    def draw(at: float) -> Any:
        return lambda: draws.append(at) or at

    decide, blind = tree.compile([0, 1], STATES), reading([NAN, NAN])
    assert [decide([None] * 2, blind, draw(d)) for d in (0.2, 0.3, 0.6)] == [1, 2, 0]
    assert draws == [0.2, 0.3, 0.6]
    assert decide([None] * 2, blind, draw(math.nextafter(1, 0))) == 0
    assert decide([None] * 2, reading([9.0, NAN]), None) == 0, "what is not needed is no matter"


def test_the_largest_draw_chooses_something_however_it_is_split() -> None:
    rng = random.Random(1)
    for _ in range(200):
        n = rng.randrange(3, 30)
        rows = [[i, i % 3, i % 5] for i in range(n)]
        tree = learned(rows, [rng.choice("ABC") for _ in rows], [CONTINUOUS] * 3)
        chosen = tree.compile(range(3), STATES)([NAN] * 3, None, lambda: math.nextafter(1.0, 0.0))
        assert chosen in STATES.values()


def test_an_explanation_says_which_value_was_missing() -> None:
    tree = learned([[1, 1], [1, 5], [9, 1], [9, 1]], ["A", "B", "C", "C"], [CONTINUOUS] * 2)
    why = tree.explain([1, NAN], ["x", "y"])
    assert why.tests == ("x <= 5", "y has no value")
    assert (why.features, why.distribution) == ((0, 1), {"A": 0.5, "B": 0.5})
    past = tree.retrace([NAN, None], ["x", "y"])
    assert (past.tests, past.features) == (("x has no value",), (0,))
    assert past.distribution == {"A": 0.25, "B": 0.25, "C": 0.5}


# A classifier in place of the tree --------------------------------------------------------------


def test_a_classifier_in_place_of_the_tree_refuses_a_missing_value_with_a_way_out() -> None:
    spec = "sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)"
    with pytest.raises(FeatureValueError, match=r'takes no missing values; .*or use "tree"'):
        learn_transition(spec, [CONTINUOUS], [[NAN], [1.0]], [*"AB"])
    function = learn_transition(spec, [CONTINUOUS], [[0.0], [1.0]], [*"AB"])
    with pytest.raises(NoValueError):
        function.compile([0], STATES)([None], reading([NAN]), None)


# An agent ---------------------------------------------------------------------------------------


class Body:
    """A body that sees what the test sets."""

    def __init__(self, name: str = "") -> None:
        self.values: Any = [0.0, 0.0]
        self.reads = 0

    def read(self, column: int) -> Any:
        self.reads += 1
        return self.values[column]


def robot(required: bool = False) -> Domain:
    return Domain.of(
        "patchy",
        "1",
        Body,
        behaviors=[BasicBehavior(name) for name in "ABC"],
        features=[
            Feature("x", lambda body: body.read(0), required=required),
            Feature("y", lambda body: body.read(1)),
        ],
    )


class Player:
    """An agent that performs one automaton."""

    def __init__(self, function: Any, *, required: bool = False) -> None:
        domain = robot(required)
        automaton = Automaton(
            "T", tuple(map(Term, "ABC")), (Term("x"), Term("y")), {START: function, "A": function}
        )
        self.body = Body()
        self.feature_cache = FeatureCache(self.body, domain)
        self.random = random.Random(5)
        context = RunContext(
            Repertoire(domain, {"T": automaton}), self.body, self.feature_cache, self.random.random
        )
        self.running: Any = performance(context, Term("T"))
        self.running.start()

    def tick(self, *values: Any) -> str:
        self.body.values = values
        self.feature_cache.forget()
        self.running.tick()
        return str(self.running.active_path[0])


def test_a_decision_goes_on_and_what_lacks_a_value_is_named_until_it_has_one() -> None:
    player = Player(learned([[1, 1], [9, 9]], ["A", "B"], [CONTINUOUS] * 2))
    assert player.feature_cache.lacking() == []
    assert player.tick(NAN, 1.0) in ("A", "B")
    lacking = 'feature "x" has no value; check its sensor'
    assert player.feature_cache.lacking() == [lacking]
    assert player.tick(NAN, 1.0) in ("A", "B")  # B needs nothing, but x still has no value
    assert player.feature_cache.lacking() == [lacking]
    player.tick(2.0, 1.0)
    assert player.feature_cache.lacking() == []
    assert player.tick(1.0, NAN) in ("A", "B")
    assert player.feature_cache.lacking() == [], "nothing needs y"


def test_without_a_required_value_nothing_is_decided() -> None:
    tree = learned([[1, 1], [9, 9]], ["A", "B"], [CONTINUOUS] * 2)
    player = Player(tree, required=True)
    with pytest.raises(FeatureValueError, match='feature "x" has no value') as refused:
        player.tick(NAN, 1.0)
    assert not isinstance(refused.value, NoValueError)
    assert player.running.active_path == [START]
    assert player.tick(1.0, 1.0) == "A"


def test_what_is_required_is_required_in_states_whose_tree_tests_nothing() -> None:
    tree = learned([[1, 1], [9, 9]], ["A", "B"], [CONTINUOUS] * 2)
    player = Player(tree, required=True)
    assert player.tick(9.0, 9.0) == "B"
    assert player.running.function is None
    with pytest.raises(FeatureValueError, match='feature "x" has no value'):
        player.tick(NAN, 9.0)
    assert player.tick(9.0, NAN) == "B", "y is not required"


def test_a_hand_written_function_decides_nothing_without_a_value() -> None:
    player = Player(HandWritten(lambda x: "A" if x < 5 else "B", (0,)))
    with pytest.raises(FeatureValueError, match='feature "x" has no value'):
        player.tick(NAN, 1.0)
    assert player.tick(1.0, 1.0) == "A"


def test_a_value_that_the_domain_refuses_is_missing_and_read_once_per_tick() -> None:
    class Sensor:
        def __float__(self) -> float:
            raise TypeError

    player = Player(learned([[1, 1], [9, 9]], ["A", "A"], [CONTINUOUS] * 2))
    assert player.tick(Sensor(), 1.0) == "A"
    slot = player.feature_cache.slot(Term("x"))
    player.body.reads = 0
    for _ in range(3):
        with pytest.raises(NoValueError):
            player.feature_cache.read(slot)
    assert player.body.reads == 1
    assert math.isnan(player.feature_cache.known(slot) or 0.0)
