"""Where boundaries are placed, and which split is taken."""

import itertools
import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hitab_core.domain import FeatureKind, Scale
from hitab_core.learning.boundaries import end_between, on_circle, threshold_between
from hitab_core.learning.gain_ratio import gain_and_ratio
from hitab_core.learning.splits import (
    Arc,
    Categories,
    Examples,
    Split,
    Threshold,
    choose_split,
    split_by,
    split_categorical,
    split_continuous,
    split_toroidal,
)

CONTINUOUS = Scale()
BOOLEAN = Scale(FeatureKind.BOOLEAN)
DEGREES = Scale(FeatureKind.TOROIDAL, 360.0)

finite = st.floats(allow_nan=False, allow_infinity=False)
flags = st.booleans()
places = st.floats(0, 360, exclude_max=True)
rows = st.lists(st.tuples(st.integers(0, 12), st.integers(0, 2), flags), min_size=1, max_size=14)


def examples(values, classes, default=None):
    """Return examples of up to three classes as one feature shows them."""
    return Examples(
        np.array(values, float),
        np.array(classes),
        np.zeros(len(values), bool) if default is None else np.array(default),
        3,
    )


def upwards(start, place, period=360.0):
    """Return how far ``place`` is from ``start`` counting upwards."""
    return (place - start) % period


def counts_of(given, first):
    """Return class counts inside and outside a set of examples."""
    return np.array([np.bincount(given.classes[s], minlength=3) for s in (first, ~first)])


# Where a boundary lies


def test_a_threshold_between_two_ordinary_examples_is_half_way():
    assert threshold_between(2, 5) == 3.5
    assert threshold_between(2, 5, below_is_default=True, above_is_default=True) == 3.5


def test_a_threshold_above_an_example_and_below_a_default_one_is_just_above_the_example():
    assert threshold_between(2, 5, above_is_default=True) == math.nextafter(2, 5)


def test_a_threshold_below_an_example_and_above_a_default_one_is_just_below_the_example():
    assert threshold_between(2, 5, below_is_default=True) == math.nextafter(5, 2)


@given(finite, finite, flags, flags)
def test_a_threshold_tells_its_neighbors_apart_however_near_or_far_they_are(
    a, b, below_is_default, above_is_default
):
    assume(a != b)
    below, above = sorted((a, b))
    threshold = threshold_between(
        below, above, below_is_default=below_is_default, above_is_default=above_is_default
    )
    assert below <= threshold < above


def test_a_threshold_tells_adjacent_numbers_apart():
    for below, below_is_default, above_is_default in itertools.product(
        [1.0, 0.0, -5e-324, -1.0, 1e308], [False, True], [False, True]
    ):
        above = math.nextafter(below, math.inf)
        threshold = threshold_between(
            below, above, below_is_default=below_is_default, above_is_default=above_is_default
        )
        assert below <= threshold < above


def test_a_threshold_half_way_between_the_ends_of_the_number_line_does_not_overflow():
    assert threshold_between(-1.7e308, 1.7e308) == 0
    assert threshold_between(1.5e308, 1.7e308) == pytest.approx(1.6e308)


def test_a_threshold_is_never_the_negative_zero():
    assert math.copysign(1, threshold_between(-5e-324, 5.0, above_is_default=True)) == 1


def test_an_end_of_an_arc_between_two_ordinary_examples_is_half_way_also_through_zero():
    assert end_between(10, 50, 360) == 30
    assert end_between(350, 20, 360) == 5
    assert end_between(340, 10, 360) == 355


def test_an_end_of_an_arc_is_just_beside_the_example_that_is_not_default():
    assert end_between(10, 50, 360, after_is_default=True) == math.nextafter(10, 50)
    assert end_between(10, 50, 360, before_is_default=True) == math.nextafter(50, 10)
    assert end_between(350, 0, 360, before_is_default=True) == math.nextafter(360, 0)
    assert end_between(math.nextafter(360, 0), 20, 360, after_is_default=True) == 0


def test_a_default_example_reaches_past_the_opposite_place_as_far_as_on_the_other_side():
    assert end_between(20, 0, 360, after_is_default=True, kept=20) == 160
    assert end_between(0, 340, 360, before_is_default=True, kept=20) == 200
    assert end_between(90, 10, 360, after_is_default=True, kept=80) == 110
    beside = math.nextafter(100, 360)
    assert end_between(100, 10, 360, after_is_default=True, kept=90) == beside
    assert end_between(100, 10, 360, after_is_default=True) == beside


@given(places, places, flags, flags, st.floats(0, 360) | st.just(math.inf))
def test_an_end_of_an_arc_is_behind_one_neighbor_and_not_behind_the_next(
    before, after, before_is_default, after_is_default, kept
):
    assume(before != after)
    end = end_between(
        before,
        after,
        360.0,
        before_is_default=before_is_default,
        after_is_default=after_is_default,
        kept=kept,
    )
    assert 0 <= end < 360
    assert before < end <= after if before < after else before < end or end <= after


def test_an_end_of_an_arc_between_adjacent_numbers_is_the_second():
    for before, before_is_default, after_is_default in itertools.product(
        [0.0, 5e-324, 0.1, 0.3, 1.0, 359.0, math.nextafter(360, 0)], [False, True], [False, True]
    ):
        after = math.nextafter(before, math.inf) % 360
        end = end_between(
            before,
            after,
            360.0,
            before_is_default=before_is_default,
            after_is_default=after_is_default,
        )
        assert end == after


def test_a_tiny_negative_angle_is_at_zero_not_at_the_period():
    assert on_circle(-1e-20, 360) == 0
    assert on_circle(-90, 360) == 270
    assert on_circle(720, 360) == 0


# Which values count as default


def test_a_value_is_default_if_all_examples_there_are():
    for default, threshold in [
        ([True, True, False, False], math.nextafter(5, 2)),  # all at 2, none at 5
        ([True, False, False, False], 3.5),  # not all at 2
        ([True, True, True, False], math.nextafter(5, 2)),  # all at 2, not all at 5
        ([True, True, True, True], 3.5),  # all
        ([True, False, True, True], math.nextafter(2, 5)),  # not all at 2, all at 5
    ]:
        split = split_continuous(examples([2, 2, 5, 5], [0, 0, 1, 1], default))
        assert split.test == Threshold(threshold)


def test_only_the_nearest_values_say_whether_a_boundary_is_beside_an_example():
    split = split_continuous(examples([1, 2, 5, 6], [0, 0, 1, 1], [True, False, False, True]))
    assert split.test == Threshold(3.5)


def test_the_two_ends_of_an_arc_are_placed_each_by_its_own_neighbors():
    split = split_toroidal(
        examples([180, 350, 0, 90], [0, 1, 1, 0], [False, False, False, True]), 360
    )
    assert split.test == Arc(265, math.nextafter(0, 1), 360)
    assert [part.tolist() for part in split.parts] == [[1, 2], [0, 3]]


# Default examples on a circle


def split_among_default_ones(demonstrated, default, *, turned_by=0.0, mirrored=False, **options):
    """Return a function from places in degrees to whether they belong to the demonstrated ones.

    Places are turned and mirrored before they are learned and asked, which should not matter.
    """

    def moved(place):
        return ((-place if mirrored else place) + turned_by) % 360

    values = [moved(place) for place in (*demonstrated, *default)]
    is_default = [False] * len(demonstrated) + [True] * len(default)
    arc = split_toroidal(
        examples(values, [int(d) for d in is_default], is_default), 360.0, **options
    ).test

    def inside(place):
        return upwards(arc.start, moved(place)) < upwards(arc.start, arc.end)

    demonstrated_inside = inside(demonstrated[0])
    return lambda place: inside(place) == demonstrated_inside


@st.composite
def among_default_ones(draw):
    """Draw neighboring demonstrated places and the default ones, multiples of 5 degrees."""
    steps = sorted(draw(st.sets(st.integers(0, 71), min_size=2, max_size=9)))
    n = draw(st.integers(1, len(steps) - 1))
    return [5 * step for step in steps[:n]], [5 * step for step in steps[n:]]


@given(st.integers(0, 1439), st.integers(0, 1439), st.integers(0, 1439))
def test_a_demonstration_beside_one_default_example_holds_for_that_side_of_the_circle(
    kept, shown, asked
):
    kept, shown, asked = kept / 4, shown / 4, asked / 4  # such numbers do not round

    def way(place):  # the shorter one from the default example
        return (place - kept + 180) % 360 - 180

    assume(kept != shown and -180 not in (way(shown), way(asked)))
    near, far = abs(way(shown)), abs(way(asked))
    assume(far != 180 - near)  # an end
    here = way(asked) * way(shown) > 0 and (near <= far < 180 - near or far == near)
    assert split_among_default_ones([shown], [kept])(asked) == here


@given(among_default_ones(), st.integers(0, 71), flags)
def test_what_a_default_example_reaches_does_not_depend_on_where_zero_is_nor_on_the_direction(
    drawn, turned, mirrored
):
    one = split_among_default_ones(*drawn)
    other = split_among_default_ones(*drawn, turned_by=5.0 * turned, mirrored=mirrored)
    for place in {a + d for a in range(0, 360, 5) for d in (0.3, 4.7)} | {*drawn[0], *drawn[1]}:
        assert one(place) == other(place)


@given(among_default_ones())
def test_only_beside_default_examples_on_one_side_more_than_was_demonstrated_is_learned(drawn):
    demonstrated, default = drawn
    first, last = demonstrated[0], demonstrated[-1]
    one_sided = upwards(last, default[0]) > 180 + upwards(default[0], first) or upwards(
        default[-1], first
    ) > 180 + upwards(last, default[-1])
    learned = split_among_default_ones(demonstrated, default)
    tight = split_among_default_ones(demonstrated, default, all_around=True)
    asked = {a + d for a in range(0, 360, 5) for d in (0, 0.3, 4.7)}
    more = {place for place in asked if learned(place) and not tight(place)}
    assert not {place for place in asked if tight(place) and not learned(place)}
    assert {*demonstrated} <= {place for place in asked if learned(place)}
    assert bool(more) == one_sided
    for place in more:  # the shorter way to it leads past what was demonstrated
        assert upwards(place, default[0]) >= 180 or upwards(default[-1], place) >= 180


# Which split is the best of a feature


@given(rows, st.integers(1, 3))
def test_a_threshold_has_the_largest_gain_of_all_thresholds(drawn, min_branch):
    given_examples = examples(*zip(*drawn, strict=True))
    split = split_continuous(given_examples, min_branch)
    gains = [
        gain_and_ratio(counts_of(given_examples, given_examples.values <= value))[0]
        for value in set(given_examples.values)
        if min((given_examples.values <= value).sum(), (given_examples.values > value).sum())
        >= min_branch
    ]
    assert (split is None) == (not gains)
    if split is not None:
        assert split.gain == pytest.approx(max(gains), abs=1e-9)
        below = given_examples.values <= split.test.threshold
        assert np.flatnonzero(below).tolist() == split.parts[0].tolist()
        assert np.flatnonzero(~below).tolist() == split.parts[1].tolist()


@given(rows, st.integers(1, 3))
def test_an_arc_has_the_largest_gain_of_all_arcs(drawn, min_branch):
    given_examples = examples(*zip(*drawn, strict=True))
    values = given_examples.values
    split = split_toroidal(given_examples, 13.0, min_branch)
    gains = []
    for start, end in combinations(sorted(set(values)), 2):
        inside = (values >= start) & (values < end)
        if min(inside.sum(), (~inside).sum()) >= min_branch:
            gains.append(gain_and_ratio(counts_of(given_examples, inside))[0])
    if len(set(given_examples.classes)) > 1:
        assert (split is None) == (not gains)
    if split is not None:
        assert split.gain == pytest.approx(max(gains), abs=1e-9)
        arc = split.test
        width = upwards(arc.start, arc.end, 13.0)
        inside = np.array([upwards(arc.start, v, 13.0) < width for v in values])
        # At the ends themselves the difference may round, which the parts do not.
        clear = np.array(
            [min(abs(v - e) % 13.0 for e in (arc.start, arc.end)) > 1e-9 for v in values]
        )
        in_part = np.isin(np.arange(len(values)), split.parts[0])
        assert (inside == in_part)[clear].all()


def test_of_equal_splits_the_one_with_the_larger_smaller_side_is_taken():
    for n_values in [4, 6, 30, 58]:
        # No split gains anything, but for rounding.
        values = np.repeat(np.arange(n_values), 3)
        given_examples = examples(values, [0, 0, 1] * n_values)
        assert split_continuous(given_examples).test == Threshold(n_values / 2 - 0.5)
        arc = split_toroidal(given_examples, float(n_values))
        assert len(arc.parts[0]) == len(arc.parts[1])
        assert arc.test == Arc(0.5, n_values / 2 + 0.5, float(n_values))


def test_of_thresholds_equal_in_all_else_the_lower_one_is_taken():
    assert split_continuous(examples([1, 2, 3], [0, 1, 0])).test == Threshold(1.5)


def test_of_equal_arcs_the_one_first_met_upwards_from_the_first_example_is_taken():
    alternating = [0, 1, 0, 1]
    at_zero = split_toroidal(examples([0, 90, 180, 270], alternating), 360)
    turned = split_toroidal(examples([180, 270, 0, 90], alternating), 360)
    assert at_zero.test == Arc(45, 135, 360)
    assert turned.test == Arc(225, 315, 360)


def test_a_split_with_fewer_examples_on_a_side_than_asked_for_is_not_considered():
    one_apart = examples([1, 2, 3, 4], [0, 1, 1, 1])
    assert split_continuous(one_apart, 1).test == Threshold(1.5)
    assert split_continuous(one_apart, 2).test == Threshold(2.5)
    assert split_continuous(one_apart, 3) is None
    assert split_toroidal(one_apart, 360, 1).test.start == 1.5
    assert split_toroidal(one_apart, 360, 2).test == Arc(1.5, 3.5, 360)
    assert split_toroidal(one_apart, 360, 3) is None


@pytest.mark.parametrize("kind", list(FeatureKind))
def test_there_is_no_split_where_all_values_are_the_same(kind):
    assert split_by(examples([1, 1, 1], [0, 1, 2]), Scale(kind, 360.0)) is None


def test_a_categorical_feature_splits_into_all_categories_seen():
    split = split_categorical(examples([4, 0, 2, 0], [0, 1, 2, 1]))
    assert split.test == Categories((0, 2, 4))
    assert [part.tolist() for part in split.parts] == [[1, 3], [2], [0]]
    assert split.gain == pytest.approx(1.5)
    assert split.ratio == pytest.approx(1)


def test_a_categorical_feature_needs_two_branches_with_the_fewest_examples_asked_for():
    assert split_categorical(examples([0, 0, 1, 1, 2], [0, 0, 1, 1, 2]), 2) is not None
    assert split_categorical(examples([0, 0, 0, 1, 2], [0, 0, 1, 1, 2]), 2) is None


def test_gain_and_gain_ratio_are_those_of_quinlans_weather_example():
    # C4.5, section 2.1: outlook splits 14 days into 2/3, 4/0 and 3/2 (play / don't).
    gain, ratio = gain_and_ratio(np.array([[2, 3], [4, 0], [3, 2]]))
    assert gain == pytest.approx(0.246, abs=1e-3)
    assert ratio == pytest.approx(0.156, abs=1e-3)


# Which feature is taken


def made(gain, ratio):
    """Return a split with this gain and ratio."""
    return Split(Threshold(0.0), gain, ratio, ())


def test_the_feature_with_the_largest_gain_ratio_is_taken():
    assert choose_split([made(0.5, 0.6), None, made(0.5, 0.7)], [CONTINUOUS] * 3)[0] == 2


def test_a_feature_that_gains_less_than_the_average_is_not_taken_whatever_its_ratio():
    assert choose_split([made(0.2, 0.9), made(0.8, 0.5)], [CONTINUOUS] * 2)[0] == 1


def test_of_equal_features_a_boolean_one_is_taken_then_the_first():
    equal = [made(1, 1)] * 4
    assert choose_split(equal, [CONTINUOUS, DEGREES, BOOLEAN, BOOLEAN])[0] == 2
    assert choose_split(equal, [DEGREES, CONTINUOUS, CONTINUOUS, CONTINUOUS])[0] == 0


def test_ties_go_to_the_first_feature_where_boolean_ones_have_no_precedence():
    equal = [made(1, 1)] * 3
    scales = [DEGREES, CONTINUOUS, BOOLEAN]
    assert choose_split(equal, scales, boolean_first=False)[0] == 0


def test_differences_that_come_from_rounding_decide_nothing():
    close = [made(1 - 1e-14, 1 - 1e-14), made(1, 1)]
    assert choose_split(close, [CONTINUOUS] * 2)[0] == 0
