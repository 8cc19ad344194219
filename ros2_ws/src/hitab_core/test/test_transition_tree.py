"""What a transition tree learns from examples, and how it decides."""

import itertools
import math
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hitab_core.domain import FeatureKind, Scale
from hitab_core.learning import tree_text
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_nodes import Arc, Categories, Fork, Leaf, Threshold, nodes
from hitab_core.learning.tree_pruning import pessimistic_errors, prune
from hitab_core.texts.errors import FeatureValueError, VocabularyError

CONTINUOUS = Scale()
BOOLEAN = Scale(FeatureKind.BOOLEAN)
DEGREES = Scale(FeatureKind.TOROIDAL, 360.0)
COLOR = Scale(FeatureKind.CATEGORICAL, 0.0, ("red", "green", "blue", "white"))
MIXED = [CONTINUOUS, DEGREES, BOOLEAN, COLOR]
NAMES = ["DistanceTo(ball)", "DirectionTo(ball)", "BallIsKickable", "Color"]
LABELS = ["GoFast", "GoSlow", "Stop"]

value_rows = st.tuples(
    st.integers(-3, 3).map(float),
    st.sampled_from([-170.0, -90.0, -1e-20, 0.0, 10.5, 90.0, 180.0, 350.0, 370.0]),
    st.sampled_from([0.0, 1.0]),
    st.sampled_from([0.0, 1.0, 2.0]),
)
queries = st.tuples(
    st.floats(-4, 4),
    st.floats(-400, 400),
    st.sampled_from([0.0, 1.0]),
    st.sampled_from([0.0, 1.0, 2.0, 3.0]),
)
taught = st.lists(
    st.tuples(value_rows, st.sampled_from(LABELS), st.booleans()), min_size=1, max_size=25
)


def learned(examples, scales=MIXED, **parameters):
    """Return a tree learned from (values, label, is default) triples."""
    X, y, default = zip(*examples, strict=True)
    return TransitionTree(scales, **parameters).fit(X, y, default)


def by_index(tree, states=("Stop", "GoSlow", "GoFast")):
    """Return the compiled decision and the labels of its indices."""
    return tree.compile(range(tree.n_features_in_), {s: i for i, s in enumerate(states)}), states


def no_reading(slot):
    """Fail: all values are there."""
    raise AssertionError(f"slot {slot} was read again")


def way_through(tree, values):
    """Return which branches lead to the leaf that values come to."""
    node, way = tree.root_, []
    while not isinstance(node, Leaf):
        way.append(node.branch_for(values[node.feature]))
        node = node.branches[way[-1]]
    return tuple(way)


# What is learned


@given(taught)
def test_every_example_that_no_other_contradicts_is_reproduced(examples):
    tree = learned(examples)
    folded = [(v[0], max(v[1] % 360, 0.0) % 360, *v[2:]) for v, _, _ in examples]
    labels_at = {}
    for place, (_, label, _) in zip(folded, examples, strict=True):
        labels_at.setdefault(place, set()).add(label)
    predicted = tree.predict_proba([v for v, _, _ in examples])
    for place, (_, label, _), odds in zip(folded, examples, predicted, strict=True):
        if len(labels_at[place]) == 1:
            assert odds[tree.labels.index(label)] == 1


def test_two_features_that_matter_only_together_are_both_tested():
    for scale in [CONTINUOUS, BOOLEAN, DEGREES, COLOR]:
        X = [[0, 0], [0, 1], [1, 0], [1, 1]]
        tree = TransitionTree([scale, scale]).fit(X, ["Stop", "GoFast", "GoFast", "Stop"])
        assert tree.predict(X).tolist() == ["Stop", "GoFast", "GoFast", "Stop"]


def test_features_that_can_never_tell_contradicting_examples_apart_are_not_tested():
    X = [[x, k] for x in (1, 2, 3) for k in (0, 1)] * 2
    y = ["Stop"] * 6 + ["GoFast"] * 6
    tree = TransitionTree([CONTINUOUS, BOOLEAN]).fit(X, y)
    assert tree.root_ == Leaf((6, 6))
    assert tree.features_used == ()


@given(taught, st.integers(1, 4))
def test_the_distribution_at_a_leaf_is_that_of_the_examples_that_came_to_it(examples, fewest):
    tree = learned(examples, min_samples_leaf=fewest)
    came = {}
    for values, label, _ in examples:
        came.setdefault(way_through(tree, values), []).append((values, label))
    for together in came.values():
        counts = Counter(label for _, label in together)
        odds = tree.predict_proba([values for values, _ in together])
        assert odds.tolist() == [[counts[s] / len(together) for s in tree.labels]] * len(together)
    leaves = Counter(n.counts for n in nodes(tree.root_) if isinstance(n, Leaf))
    assert leaves == Counter(
        tuple(Counter(label for _, label in together)[s] for s in tree.labels)
        for together in came.values()
    )


LOST_AT_5_M = [
    ((8.2, 1), "Stop", True),
    ((6.7, 1), "Stop", True),
    ((2.5, 1), "Pass", False),
    ((5.0, 0), "Fetch", False),
]
"""A ball was passed with a taker at 2.5 m, and lost with one at 5 m."""


@pytest.mark.parametrize("scale", [BOOLEAN, COLOR])
@pytest.mark.parametrize("distance", [CONTINUOUS, DEGREES])
def test_a_boundary_beside_an_example_of_one_class_is_not_that_of_another(distance, scale):
    turned = [((d * 10.0 if distance is DEGREES else d, k), y, o) for (d, k), y, o in LOST_AT_5_M]
    far, near, lost = (40.0, 20.0, 90.0) if distance is DEGREES else (4.0, 2.0, 9.0)
    tree = learned(turned, [distance, scale])
    asked = [(far, 1), (near, 1), (lost, 0)]
    assert tree.predict(asked).tolist() == ["Stop", "Pass", "Fetch"]
    blind = learned(turned, [distance, scale], look_ahead=False)
    assert blind.predict(asked[:1]).tolist() == ["Pass"]


CORRECTED = [
    ((8.2, 1), "Stop", True),
    ((12.2, 1), "Stop", True),
    ((2.5, 1), "Pass", False),
    ((12.2, 0), "Fetch", False),
    ((3.7, 1), "Pass", False),
]
"""A pass with a taker at 2.5 m, corrected to 3.7 m; no ball was lost with one as near."""


def test_what_was_shown_with_the_ball_is_not_done_without_it():
    scales = [CONTINUOUS, BOOLEAN]
    assert learned(CORRECTED, scales).predict([(3.0, 0), (3.0, 1)]).tolist() == ["Fetch", "Pass"]
    blind = learned(CORRECTED, scales, look_ahead=False)
    assert blind.predict([(3.0, 0)]).tolist() == ["Pass"]


def test_looking_ahead_costs_no_leaves():
    """A boolean that separates nothing more than the distance would not come first."""
    examples = [*LOST_AT_5_M, ((4.0, 0), "Pass", False), ((5.5, 1), "Fetch", False)]
    scales = [CONTINUOUS, BOOLEAN]
    assert learned(examples, scales).root_ == learned(examples, scales, look_ahead=False).root_


@given(taught)
@settings(deadline=None)
def test_looking_ahead_never_makes_a_tree_larger(examples):
    def leaves(tree):
        return sum(isinstance(node, Leaf) for node in nodes(tree.root_))

    assert leaves(learned(examples)) <= leaves(learned(examples, look_ahead=False))


def test_both_ends_of_an_arc_lie_beside_examples_among_default_ones():
    tree = TransitionTree([DEGREES]).fit(
        [[-90], [-10], [10], [90]],
        ["Turn", "Go", "Go", "Turn"],
        default=[True, False, False, True],
    )
    turned_away = [[-10.001], [10.001], [180]]
    assert tree.predict([[-10], [0], [10], [355]]).tolist() == ["Go"] * 4
    assert tree.predict(turned_away).tolist() == ["Turn"] * 3
    assert tree.root_.branch_for(-10) != tree.root_.branch_for(-10.001)


def test_one_demonstration_among_default_ones_holds_for_a_side_of_the_circle():
    shown, kept = [[-20]], [[-4], [0], [5]]
    states, default = ["Turn", "Go", "Go", "Go"], [False, True, True, True]
    tree = TransitionTree([DEGREES]).fit(shown + kept, states, default)
    assert tree.predict([[-20], [-90], [-149.9]]).tolist() == ["Turn"] * 3
    assert tree.predict([[-19.9], [0], [20], [170], [-150.1]]).tolist() == ["Go"] * 5
    both = TransitionTree([DEGREES]).fit(
        [[25], *shown, *kept], ["Turn", *states], [False, *default]
    )
    assert (
        both.predict([[-20], [180], [25], [-19.9], [24.9]]).tolist() == ["Turn"] * 3 + ["Go"] * 2
    )


def test_a_category_that_was_not_seen_gets_the_distribution_of_its_node():
    tree = TransitionTree([COLOR]).fit([[0], [0], [2]], ["Stop", "Stop", "GoFast"])
    assert isinstance(tree.root_.test, Categories)
    assert tree.predict_proba([[0], [2], [1], [3]]).tolist() == [
        [0, 1],
        [1, 0],
        [1 / 3, 2 / 3],
        [1 / 3, 2 / 3],
    ]


def test_depth_and_branch_size_are_limited_where_asked():
    X, y = [[i] for i in range(8)], list("ABABBBBB")
    assert TransitionTree(max_depth=0).fit(X, y).root_ == Leaf((2, 6))
    shallow = TransitionTree(max_depth=1).fit(X, y).root_
    assert all(isinstance(branch, Leaf) for branch in shallow.branches)
    leaves = nodes(TransitionTree(min_samples_leaf=3).fit(X, y).root_)
    assert min(sum(n.counts) for n in leaves) == 3


def test_a_tree_as_deep_as_it_has_examples_is_learned_read_and_run():
    X, y = np.arange(1500.0)[:, None], ["GoFast", "Stop"] * 750
    tree = TransitionTree().fit(X, y)
    assert tree.predict(X).tolist() == y
    assert len(tree.rules(["x"])) == 1500
    assert len(tree.digest()) == 64
    assert tree.root_.counts == (750, 750)


# Zero may be put anywhere


@settings(max_examples=200)
@given(
    st.lists(
        st.tuples(st.integers(0, 35), st.integers(0, 2), st.sampled_from(LABELS), st.booleans()),
        min_size=1,
        max_size=25,
    ),
    st.floats(-800, 800),
    st.integers(1, 3),
    st.booleans(),
)
@example(  # an example of another branch lies at an end
    [
        *[(0, 0, "GoFast", False)] * 2,
        (0, 1, "GoSlow", False),
        (17, 1, "GoFast", False),
        (24, 0, "GoFast", False),
        (31, 1, "GoSlow", False),
    ],
    0.16,
    1,
    False,
)
def test_a_toroidal_feature_gives_the_same_leaf_wherever_its_zero_is_put(
    drawn, offset, fewest, prune
):
    def turned(by):
        return learned(
            [((a * 10 + by, b), label, default) for a, b, label, default in drawn],
            [DEGREES, CONTINUOUS],
            min_samples_leaf=fewest,
            prune=prune,
        )

    here, there = turned(0.0), turned(offset)
    assert [n.counts for n in nodes(here.root_)] == [n.counts for n in nodes(there.root_)]
    # Ends lie at multiples of 5 or just beside, half-way between examples of their node. So these
    # are examples, which lie at no end on their way, or not near an end.
    shown = {(a * 10, b) for a, b, _, _ in drawn}
    between = {a + d for a in range(0, 360, 10) for d in (0.3, 4.7, 5.3, 9.7)}
    asked = [*shown, *((place, b) for place in between for b in (0, 1, 2))]
    assert np.array_equal(
        here.predict_proba(asked), there.predict_proba([[p + offset, b] for p, b in asked])
    )


def test_an_end_of_an_arc_belongs_to_the_side_above_it_also_at_zero():
    for order, labels, turn in itertools.product(
        [(0, 1, 2), (1, 0, 2), (2, 1, 0)], ["AAB", "ABA", "BAA", "ABC"], [0, 10, 95, 180, -75]
    ):
        # Ends lie at 0, 95 and 265, turned; so some are exactly at zero.
        places = [-10 + turn, 10 + turn, 180 + turn]
        tree = TransitionTree([DEGREES]).fit(
            [[places[i]] for i in order], [labels[i] for i in order]
        )
        decide, states = by_index(tree, tree.labels)
        for end, above, below in ((0, 1, 0), (95, 2, 1), (265, 0, 2)):
            at = end + turn
            for place, index in (
                (at, above),
                (at + 360, above),
                (at + 1e-9, above),
                (at - 1e-9, below),
                (at % 360 - 1e-20, above),  # too little to be another place than the end
            ):
                label = labels[index]
                assert tree.explain([place], ["a"]).distribution == {label: 1}
                assert tree.predict([[place]]).tolist() == [label]
                assert states[decide([float(place)], no_reading, None)] == label


# The same as others find


def best_by_feature(X, y, rows):
    """Return for each feature (gain, ratio, threshold) of its best thresholds, best first."""

    def entropy(labels):
        _, n = np.unique(labels, return_counts=True)
        return -(n / n.sum() * np.log2(n / n.sum())).sum()

    found = []
    for f in range(X.shape[1]):
        column, options = X[rows, f], []
        distinct = np.unique(column)
        for low, high in pairwise(distinct):
            left = column <= low
            share = left.mean()
            gain = entropy(y[rows]) - share * entropy(y[rows][left])
            gain -= (1 - share) * entropy(y[rows][~left])
            options.append((gain, gain / entropy(left), (low + high) / 2))
        found.append(sorted(options, reverse=True))
    return found


def one_choice(found):
    """Return feature and threshold if gain and gain ratio choose the same, without a tie."""
    best = [(options[0], f) for f, options in enumerate(found) if options]
    for options in found:
        if len(options) > 1 and options[0][0] - options[1][0] < 1e-6:
            return None
    gains = sorted((b[0] for b, _ in best), reverse=True)
    if not gains or (len(gains) > 1 and gains[0] - gains[1] < 1e-6) or gains[0] < 1e-6:
        return None
    worthy = sorted(
        ((b[1], f, b[2], b[0]) for b, f in best if b[0] >= sum(gains) / len(gains)), reverse=True
    )
    if len(worthy) > 1 and worthy[0][0] - worthy[1][0] < 1e-6:
        return None
    return worthy[0][1:3] if worthy[0][3] == gains[0] else None


@pytest.mark.parametrize("n_features", [1, 2, 4])
def test_where_gain_and_gain_ratio_choose_alike_the_tree_is_scikit_learns(n_features):
    from sklearn.tree import DecisionTreeClassifier

    random = np.random.default_rng(n_features)
    compared = 0
    for _ in range(30):
        X = random.permuted(np.tile(np.arange(40.0), (n_features, 1)), axis=1).T
        y = np.where(X[:, 0] + 6 * random.normal(size=40) > 20, "Stop", "GoFast")
        theirs = DecisionTreeClassifier(criterion="entropy", random_state=0).fit(X, y).tree_
        waiting = [(TransitionTree().fit(X, y).root_, 0, np.arange(40))]
        while waiting:
            mine, index, rows = waiting.pop()
            assert isinstance(mine, Leaf) == (theirs.feature[index] < 0)
            assert np.allclose(np.array(mine.counts) / sum(mine.counts), theirs.value[index])
            choice = one_choice(best_by_feature(X, y, rows))
            if isinstance(mine, Leaf) or choice is None:
                continue
            assert (mine.feature, mine.test.threshold) == choice
            assert (theirs.feature[index], theirs.threshold[index]) == choice
            left = X[rows, mine.feature] <= mine.test.threshold
            waiting.append((mine.branches[0], theirs.children_left[index], rows[left]))
            waiting.append((mine.branches[1], theirs.children_right[index], rows[~left]))
            compared += 1
    assert compared > 50


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.SkipTestWarning")
def test_the_scikit_learn_form_of_the_tree_passes_scikit_learns_checks():
    from sklearn.utils.estimator_checks import check_estimator

    from hitab_core.learning.scikit_learn import TransitionTreeClassifier

    for classifier in (TransitionTreeClassifier(), TransitionTreeClassifier(prune=True)):
        results = check_estimator(classifier)
        assert sum(result["status"] == "passed" for result in results) > 40


# Deciding


@given(taught, queries)
def test_the_compiled_decision_draws_from_the_distribution_that_is_predicted(examples, query):
    tree = learned(examples, max_depth=2)
    decide, states = by_index(tree)
    odds = dict(zip(tree.labels, tree.predict_proba([query])[0], strict=True))
    n = 1200
    drawn = Counter(
        states[decide(list(query), no_reading, lambda i=i: (i + 0.5) / n)] for i in range(n)
    )
    for label in tree.labels:
        assert abs(drawn[label] / n - odds[label]) <= 1 / n
    assert set(drawn) == {label for label, p in odds.items() if p > 0}


@given(taught, st.one_of(queries, value_rows))
def test_the_explanation_the_prediction_and_the_decision_agree(examples, query):
    tree = learned(examples, max_depth=3)
    explained = tree.explain(query, NAMES)
    odds = dict(zip(tree.labels, tree.predict_proba([query])[0].tolist(), strict=True))
    assert explained.distribution == {label: p for label, p in odds.items() if p > 0}
    likely = tree.compile(range(4), {s: i for i, s in enumerate(tree.labels)}, most_probable=True)
    chosen = tree.labels[likely(list(query), no_reading, None)]
    assert odds[chosen] == max(odds.values())
    assert chosen == tree.predict([query])[0]
    assert set(explained.features) <= set(tree.features_used)


def test_states_are_drawn_in_the_order_of_their_indices_however_they_are_called():
    tree = TransitionTree([]).fit(np.empty((4, 0)), ["A", "B", "B", "B"])
    states = {"B": 1, "A": 5}
    decide = tree.compile([], states)
    assert [decide([], None, lambda d=d: d) for d in (0, 0.74, 0.75, 0.99)] == [1, 1, 5, 5]


def test_of_equally_probable_states_the_most_probable_is_the_one_with_the_lowest_index():
    tree = TransitionTree([]).fit(np.empty((4, 0)), ["A", "A", "B", "B"])
    assert tree.compile([], {"B": 1, "A": 5}, most_probable=True)([], None, None) == 1
    assert tree.predict(np.empty((1, 0))).tolist() == ["A"]


def test_a_certain_decision_uses_no_draw():
    tree = TransitionTree().fit([[1], [2]], ["Stop", "GoFast"])
    assert tree.compile([0], {"Stop": 7, "GoFast": 8})([1.0], no_reading, None) == 7


def test_only_features_on_the_way_are_read_and_from_their_slots():
    X = [[1, 0], [1, 1], [5, 0], [5, 1], [6, 0]]
    y = ["Stop", "Stop", "GoFast", "GoSlow", "GoFast"]
    tree = TransitionTree([CONTINUOUS, BOOLEAN]).fit(X, y)
    assert tree.features_used == (0, 1)
    decide = tree.compile([3, 1], {"Stop": 0, "GoSlow": 1, "GoFast": 2})
    values, read = [None] * 4, []

    def reading(slot):
        read.append(slot)
        values[slot] = {3: 1.0, 1: 1.0}[slot]
        return values[slot]

    assert decide(values, reading, None) == 0
    assert read == [3]
    values[3] = 5.0
    assert decide(values, reading, None) == 1
    assert read == [3, 1]
    assert decide(values, reading, None) == 1
    assert read == [3, 1]


def test_a_state_that_the_automaton_does_not_have_is_refused_by_name():
    tree = TransitionTree().fit([[1], [2]], ["Stop", "GoFast"])
    with pytest.raises(VocabularyError, match=r'"GoFast".*\(known: Stop\)'):
        tree.compile([0], {"Stop": 0})


# What is refused


@pytest.mark.parametrize("bad", [math.inf, -math.inf])
def test_infinite_values_are_refused_by_the_name_of_the_feature(bad):
    tree = TransitionTree(feature_names=["DistanceTo(ball)", "Speed"])
    wanted = r'feature 1 "Speed" has value -?inf in row 1, which is not finite'
    with pytest.raises(FeatureValueError, match=wanted):
        tree.fit([[1, 2], [1, bad]], ["Stop", "GoFast"])
    tree.fit([[1, 2], [1, 3]], ["Stop", "GoFast"])
    for term in (tree.predict, tree.predict_proba):
        with pytest.raises(FeatureValueError, match=wanted):
            term([[1, 2], [1, bad]])
    with pytest.raises(FeatureValueError, match='feature 1 "v"'):
        tree.explain([1, bad], ["d", "v"])
    with pytest.raises(FeatureValueError, match="feature 0 has value"):
        TransitionTree().fit([[bad]], ["Stop"])


def test_values_that_a_feature_cannot_have_are_refused():
    for scale, bad, why in [
        (BOOLEAN, 0.5, "0 or 1"),
        (COLOR, 4, "0 to 3"),
        (COLOR, 1.5, "0 to 3"),
        (COLOR, -1, "0 to 3"),
        (Scale(FeatureKind.CATEGORICAL), 0.1, "0, 1, 2"),
    ]:
        tree = TransitionTree([CONTINUOUS, scale])
        with pytest.raises(FeatureValueError, match=f"feature 1 has value {bad}.*{why}"):
            tree.fit([[1, 0], [2, bad]], ["Stop", "GoFast"])


def test_wrong_shapes_and_parameters_are_refused():
    for arguments in (
        ([1, 2], ["A", "B"]),
        ([[1], [2]], ["A"]),
        ([[1], [2]], ["A", "B"], [True]),
        (np.empty((0, 1)), []),
    ):
        with pytest.raises(ValueError, match="expected"):
            TransitionTree().fit(*arguments)
    with pytest.raises(ValueError, match="expected values of shape"):
        TransitionTree([CONTINUOUS] * 2).fit([[1]], ["A"])
    for wrong in ({"min_samples_leaf": 0}, {"max_depth": -1}, {"confidence": 0.0}):
        with pytest.raises(ValueError, match="must be"):
            TransitionTree(**wrong).fit([[1]], ["A"])
    with pytest.raises(AttributeError, match="call fit first"):
        TransitionTree().predict([[1]])


# Words


def a_tree():
    """Return a tree with a test of each kind."""
    return TransitionTree(MIXED, feature_names=NAMES).fit(
        [
            [1, 0, 0, 0],
            [2, 90, 0, 0],
            [3, 180, 0, 0],
            [6, -10, 0, 0],
            [6, 10, 0, 0],
            [6, 100, 0, 0],
            [6, 250, 0, 0],
            [9, 100, 1, 0],
            [9, 100, 1, 2],
            [9, 100, 1, 0],
            [9, 100, 1, 0],
        ],
        ["Stop"] * 3 + ["GoFast"] * 2 + ["GoSlow"] * 2 + ["Pass", "Stop", "Pass", "Stop"],
    )


def test_there_is_a_rule_for_each_leaf():
    rules = a_tree().rules(NAMES)
    assert str(rules[0]) == (
        "if not BallIsKickable and DistanceTo(ball) <= 4.5: Stop (3 examples)"
    )
    assert str(rules[1]) == (
        "if not BallIsKickable and DistanceTo(ball) > 4.5 and DirectionTo(ball) outside -60..55: "
        "GoSlow (2 examples)"
    )
    assert rules[3].distribution == {"Pass": 2 / 3, "Stop": 1 / 3}
    assert len(rules) == 6
    always = TransitionTree().fit([[1]], ["A"]).rules(["x"])
    assert [str(rule) for rule in always] == ["always: A (1 example)"]


def test_what_a_path_says_of_one_feature_is_one_condition():
    tree = TransitionTree([CONTINUOUS]).fit([[1], [3], [5], [7]], list("ABCA"))
    assert sorted(rule.conditions for rule in tree.rules(["x"])) == [
        ("2 < x <= 4",),
        ("4 < x <= 6",),
        ("x <= 2",),
        ("x > 6",),
    ]


def test_rows_of_one_feature_say_together_what_holds_there():
    """Nested, an arc within the rest of another one reads as a contradiction."""
    tree = TransitionTree([CONTINUOUS]).fit([[1], [3], [5], [7]], list("ABCA"))
    assert tree.as_text(["x"]).splitlines() == [
        "x <= 2: A (1)", "2 < x <= 4: B (1)", "4 < x <= 6: C (1)", "x > 6: A (1)",
    ]  # fmt: skip
    circle = Arc(330.0, 30.0, 360.0), Arc(329.0, 30.0, 360.0)
    sliver = Fork(0, circle[1], (1, 1), (Leaf((1, 0)), Leaf((0, 1))))
    rows = tree_text.rows(Fork(0, circle[0], (1, 2), (Leaf((1, 0)), sliver)), [DEGREES], ["a"])
    assert [(depth, text) for depth, text, *_ in rows] == [
        (0, "a in -30..30"), (0, "a in -31..-30"), (0, "a outside -31..30"),
    ]  # fmt: skip
    lines = a_tree().as_text(NAMES).splitlines()
    assert [line.count("|   ") for line in lines] == [0, 1, 1, 2, 2, 0, 1, 1, 1]
    explained = tree.explain([5], ["x"])
    assert explained.tests == ("4 < x <= 6",)


def test_a_boundary_beside_an_example_is_written_as_on_its_side_of_the_example():
    def conditions(values, default, scale):
        tree = TransitionTree([scale]).fit([[v] for v in values], ["A", "B"], default)
        return [rule.conditions for rule in tree.rules(["x"])]

    assert conditions([2, 5], [True, False], CONTINUOUS) == [("x < 5",), ("x >= 5",)]
    assert conditions([2, 5], [False, True], CONTINUOUS) == [("x <= 2",), ("x > 2",)]
    assert conditions([0, 5], [False, True], CONTINUOUS) == [("x <= 0",), ("x > 0",)]
    assert conditions([-5, 0], [True, False], CONTINUOUS) == [("x < 0",), ("x >= 0",)]
    assert conditions([-10, 90], [False, True], DEGREES) == [("x != -10",), ("x = -10",)]
    assert conditions([90, 0], [True, False], DEGREES) == [("x = 0",), ("x != 0",)]
    tree = TransitionTree([DEGREES]).fit(
        [[-20], [20], [90]], ["A", "A", "B"], [False, False, True]
    )
    assert [rule.conditions for rule in tree.rules(["x"])] == [
        ("x outside -20..20",),
        ("x in -20..20",),
    ]
    tree = TransitionTree().fit([[1], [2], [3]], ["A", "B", "A"], [True, False, True])
    assert ("x = 2",) in [rule.conditions for rule in tree.rules(["x"])]


@given(st.lists(st.tuples(st.integers(0, 11), st.sampled_from("ABC")), min_size=2, max_size=12))
def test_of_the_arcs_on_a_path_the_part_that_they_share_is_written(drawn):
    tree = TransitionTree([DEGREES]).fit([[30 * a] for a, _ in drawn], [c for _, c in drawn])
    rules = tree.rules(["a"])
    drawing = [line.rpartition(": ")[0] for line in tree.as_text(["a"]).splitlines()]
    assert drawing == [" and ".join(rule.conditions) for rule in rules]
    for place in np.arange(1.0, 360, 5):
        held = []
        for rule in rules:
            arcs = [
                ends if word == "in" else ends[::-1]
                for condition in rule.conditions
                for arc in condition.removeprefix("a ").split(" or ")
                for word, _, numbers in [arc.partition(" ")]
                for ends in [tuple(map(float, numbers.split("..")))]
            ]
            if not arcs or any((place - s) % 360 < (e - s) % 360 for s, e in arcs):
                held.append(rule.distribution)
        assert held == [tree.explain([place], ["a"]).distribution]


def test_an_arc_of_radians_is_written_in_degrees_with_the_lower_end_first():
    for start, end, words in [
        (-10, 10, "in -10..10 deg"),
        (10, -10, "outside -10..10 deg"),
        (-1.5, -6.5, "outside -6.5..-1.5 deg"),
        (170, -170, "outside -170..170 deg"),
        (-180, -60, "in -180..-60 deg"),
        (60, 180, "in 60..180 deg"),
        (0, 90, "in 0..90 deg"),
        (-90, 0, "in -90..0 deg"),
        (59.98, -59.98, "outside -60..60 deg"),
        (20.01, 20.02, "in 20.01..20.02 deg"),
        (0, 1e-13, "= 0"),
        (1e-13, 0, "!= 0"),
        (60, 60 + 1e-9, "= 60 deg"),
        (60 + 1e-9, 60, "!= 60 deg"),
        (180, 180 + 1e-9, "= 180 deg"),
        (-180 + 1e-9, 180 - 1e-9, "!= 180 deg"),
    ]:
        turn = Scale(FeatureKind.TOROIDAL, math.tau)
        around = [math.radians(place) % math.tau for place in (start, end)]
        node = Fork(0, Arc(*around, math.tau), (1, 1), (Leaf((1, 0)), Leaf((0, 1))))
        assert tree_text.conditions([(node, 0)], [turn], ["a"]) == (f"a {words}",)


def test_an_explanation_tells_the_tests_in_order_and_the_features_looked_at():
    explained = a_tree().explain([6, 460, 0, 3], NAMES)
    assert explained.tests == (
        "not BallIsKickable",
        "DistanceTo(ball) > 4.5",
        "DirectionTo(ball) outside -60..55",
    )
    assert explained.features == (2, 0, 1)
    assert explained.distribution == {"GoSlow": 1.0}
    unseen = a_tree().explain([6, 100, 1, 3], NAMES)
    assert unseen.tests[-1] == "Color is none of red, blue"
    assert unseen.distribution == {"Pass": 0.5, "Stop": 0.5}


# Digests


def test_the_digest_is_the_same_for_the_same_examples_on_any_machine():
    assert a_tree().digest() == (
        "2d3c0e9e03123e697eee398c0450459ee2deacdf9bce256d95598b93347c8d93"
    )


def test_the_digest_differs_if_a_threshold_differs_in_its_last_bit():
    def tree(below):
        return TransitionTree().fit([[below], [2.0]], ["A", "B"])

    assert tree(1.0).digest() != tree(math.nextafter(1, 0) - 1e-15).digest()
    assert tree(1.0).digest() == tree(1.0).digest()


# Pruning


def test_pessimistic_errors_are_those_of_quinlans_example():
    # C4.5, section 4.2: three leaves without errors against one leaf with one.
    assert pessimistic_errors(0, 6, 0.25) == pytest.approx(6 * 0.206, abs=0.01)
    assert pessimistic_errors(0, 9, 0.25) == pytest.approx(9 * 0.143, abs=0.01)
    assert pessimistic_errors(0, 1, 0.25) == pytest.approx(0.750)
    assert pessimistic_errors(1, 16, 0.25) == pytest.approx(16 * 0.157, rel=0.05)


def test_a_leaf_replaces_a_subtree_that_expects_up_to_a_tenth_of_an_error_less():
    slightly = Fork(0, Threshold(1.0), (5, 4), (Leaf((3, 1)), Leaf((2, 3))))
    clearly = Fork(0, Threshold(1.0), (8, 4), (Leaf((6, 1)), Leaf((2, 3))))

    def errors(node):
        return pessimistic_errors(min(node.counts), sum(node.counts), 0.25)

    for node, saved in ((slightly, 0.093), (clearly, 0.102)):
        difference = errors(node) - sum(map(errors, node.branches))
        assert difference == pytest.approx(saved, abs=5e-4)
    assert prune(slightly) == Leaf((5, 4))
    assert prune(clearly) == clearly


def test_pruning_makes_a_subtree_that_only_fits_noise_a_leaf():
    X = [[i] for i in range(40)]
    y = ["Stop" if i < 20 else "GoFast" for i in range(40)]
    y[7] = "GoFast"
    full = TransitionTree().fit(X, y)
    pruned = TransitionTree(prune=True).fit(X, y)
    assert len(nodes(full.root_)) == 7
    assert pruned.root_ == Fork(0, Threshold(19.5), (21, 19), (Leaf((1, 19)), Leaf((20, 0))))


@given(taught, st.sampled_from([0.05, 0.25, 0.5]))
def test_a_pruned_tree_is_the_tree_with_some_nodes_made_leaves(examples, confidence):
    full = learned(examples).root_
    waiting = [(full, learned(examples, prune=True, confidence=confidence).root_)]
    while waiting:
        whole, pruned = waiting.pop()
        assert whole.counts == pruned.counts
        if not isinstance(pruned, Leaf):
            assert type(whole) is type(pruned)
            assert whole.feature == pruned.feature
            waiting.extend(zip(whole.branches, pruned.branches, strict=True))


@given(
    st.floats(-1e9, 1e9),
    st.floats(1e-6, 1e3),
)
@example(1e6, 2.5e-4)
def test_a_rule_tells_the_two_ends_of_a_range_apart_however_close_they_are(low, gap):
    high = low + gap * max(1.0, abs(low)) / 1e3
    ends = Threshold(high), Threshold(low)
    inner = Fork(0, ends[1], (1, 1), (Leaf((1, 0)), Leaf((0, 1))))
    tree = TransitionTree.of(
        Fork(0, ends[0], (2, 1), (inner, Leaf((1, 0)))), ["A", "B"], [Scale()]
    )
    (rule,) = [rule for rule in tree.rules("x") if ": B" in str(rule)]
    words = str(rule).removeprefix("if ").split(": B")[0].split()
    assert words[2] == "x"
    assert float(words[0]) < float(words[4])
    assert float(words[0]) == pytest.approx(low, rel=1e-5)
    assert float(words[4]) == pytest.approx(high, rel=1e-5)
