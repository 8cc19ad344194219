"""Telling mistaken examples from too few, and saying so."""

import math
from random import Random

import pytest
from unlearning import Correction, ProposalKind, propose, suspects

from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example, ExampleKind, contradictions
from hitab_core.texts.errors import TrainingError

METERS = Scale()
DIRECTION = Scale(FeatureKind.TOROIDAL, 360.0)
NAMES = ("DistanceTo(ball)",)


def shown(*rows, state="GoMedium", numbered_from=1):
    """Return ordinary examples of one state, a command each."""
    return [
        Example(state, features, to, number=n, command=n)
        for n, (features, to) in enumerate(rows, numbered_from)
    ]


APPROACH = [
    Example("Start", (12.2,), "GoMedium", number=1, command=1),
    Example("GoMedium", (4.5,), "GoMedium", ExampleKind.DEFAULT, 2, 2),
    Example("GoMedium", (1.8,), "GoFast", number=3, command=3),  # GoSlow was meant
    Example("GoFast", (1.8,), "GoFast", ExampleKind.DEFAULT, 4, 3),
    Example("GoMedium", (3.0,), "GoMedium", ExampleKind.DEFAULT, 5, 4),
    Example("GoMedium", (6.0,), "GoFast", number=6, command=5),
]


def to_slow(distance):
    return Correction("GoMedium", (distance,), "GoFast", "GoSlow")


def test_an_example_beside_a_correction_is_a_mistake_and_goes_with_its_default_example():
    proposal, *others = propose(APPROACH, [METERS], [to_slow(1.7)], names=NAMES)
    assert others == []
    assert proposal.kind is ProposalKind.MISTAKE
    assert (proposal.state, proposal.examples) == ("GoMedium", (3, 4))
    assert proposal.instead == "GoSlow"
    assert proposal.corrections == (0,)
    assert proposal.evidence == (
        "you showed GoSlow with DistanceTo(ball) = 1.7 (your correction), "
        "and GoFast with DistanceTo(ball) = 1.8",
    )
    assert "instead of GoFast" in proposal.change


def test_a_correction_far_from_every_example_asks_for_one_more_in_between():
    (proposal,) = propose(APPROACH, [METERS], [to_slow(0.3)], names=NAMES)
    assert proposal.kind is ProposalKind.SPARSE
    assert proposal.examples == (3,)
    assert proposal.place == pytest.approx((1.05,))
    assert proposal.instead == "GoSlow"


def test_between_a_correction_and_what_was_shown_is_asked_once():
    asked = Correction("GoMedium", (0.3,), "GoFast", "GoSlow", since=5)
    place = (1.05,)
    for label in ("GoFast", "GoSlow"):
        answer = Example("GoMedium", place, label, ExampleKind.CORRECTION, 7, 6)
        places = [p.place for p in propose([*APPROACH, answer], [METERS], [asked], names=NAMES)]
        assert [p for p in places if p is not None] == [], label


@pytest.mark.parametrize(("held", "places"), [(0.0, [(3.0, 0.0)]), (1.0, [])])
def test_what_a_boolean_tells_apart_needs_no_number_in_between(held, places):
    examples = shown(((5.0, 0.0), "GoFast"), ((6.0, 0.0), "GoFast"))
    told = [Correction("GoMedium", (1.0, held), "GoFast", "GoSlow")]
    assert [
        p.place for p in propose(examples, [METERS, Scale(FeatureKind.BOOLEAN)], told)
    ] == places


def test_of_very_many_examples_mistakes_are_found_without_trying_each_out():
    many = [((0.1 * i,), "GoSlow" if i < 40 else "GoFast") for i in range(80)]
    many[20] = (many[20][0], "GoFast")
    told = [Correction("GoMedium", (2.02,), "GoFast", "GoSlow")]
    (proposal,) = propose(shown(*many), [METERS], told)
    assert (proposal.examples, proposal.corrections) == ((21,), (0,))
    assert proposal.change == "GoMedium is learned again without it"


def test_each_further_correction_around_an_example_makes_a_mistake_likelier():
    scores = [
        propose(APPROACH, [METERS], [to_slow(d) for d in (1.7, 1.5, 1.9)[:n]])[0].score
        for n in (1, 2, 3)
    ]
    assert scores == sorted(set(scores))


def test_a_correction_that_recorded_an_example_is_not_heard_twice():
    recorded = Example("GoMedium", (1.7,), "GoSlow", ExampleKind.CORRECTION, 7, 6)
    told = Correction("GoMedium", (1.7,), "GoFast", "GoSlow", number=7)
    with_it = propose([*APPROACH, recorded], [METERS], [told])
    assert with_it == propose(APPROACH, [METERS], [to_slow(1.7)])


def test_booleans_and_categories_are_the_same_or_not_and_circles_close():
    examples = shown(
        ((1.0, 359.0), "Stop"), ((1.0, 1.0), "GoFast"), ((1.0, 3.0), "Stop"), ((0.0, 1.0), "Pass")
    )
    told = [Correction("GoMedium", (1.0, d), "GoFast", "Stop") for d in (0.5, 1.0)]
    proposal, *others = propose(examples, [Scale(FeatureKind.BOOLEAN), DIRECTION], told)
    assert others == []
    assert (proposal.kind, proposal.examples) == (ProposalKind.MISTAKE, (2,))
    other_side = [Correction("GoMedium", (0.0, 1.0), "Pass", "Stop")] * 2
    assert propose(examples, [Scale(FeatureKind.BOOLEAN), DIRECTION], other_side)[0].examples == (
        4,
    )


def test_a_missing_value_does_not_hinder_judging_by_the_others():
    scales = [METERS, METERS]
    examples = shown(
        ((1.0, math.nan), "Stop"),
        ((1.1, 2.1), "GoFast"),
        ((1.2, math.nan), "Stop"),
        ((9.0, 2.0), "GoFast"),
    )
    told = [Correction("GoMedium", (1.1, 2.1), "GoFast", "Stop")] * 2
    proposals = propose(examples, scales, told)
    assert proposals[0].examples == (2,)


def wavering_sides(seed):
    """Return examples and corrections about a threshold of 5 m that wavers by 15%."""
    random = Random(seed)

    def meant(distance):
        return "GoSlow" if distance < 5.0 * random.uniform(0.85, 1.15) else "GoFast"

    distances = [random.uniform(2.0, 9.0) for _ in range(4)]
    distances += [random.uniform(4.2, 5.8) for _ in range(4)]
    examples = shown(*(((d,), meant(d)) for d in distances))
    told = []
    for distance in [random.uniform(4.2, 5.8) for _ in range(2)]:
        right = meant(distance)
        wrong = "GoFast" if right == "GoSlow" else "GoSlow"
        told.append(Correction("GoMedium", (distance,), wrong, right))
    return examples, told


def test_thresholds_that_waver_by_15_percent_are_no_mistakes():
    lost = []
    for seed in range(20):
        examples, told = wavering_sides(seed)
        proposals = propose(examples, [METERS], told)
        removed = {n for p in proposals if p.kind is ProposalKind.MISTAKE for n in p.examples}
        clear = {e.number for e in examples if not 4.25 <= e.features[0] <= 5.75}
        assert removed & clear == set()
        assert suspects(examples, [METERS]) == []
        lost.append(len(removed))
    assert sorted(lost)[len(lost) // 2] == 0


def test_without_a_correction_only_what_all_near_examples_contradict_is_suspicious():
    slow = [((1.0 + 0.1 * i,), "GoSlow") for i in range(6)]
    fast = [((6.0 + 0.1 * i,), "GoFast") for i in range(6)]
    assert suspects(shown(*slow, *fast), [METERS]) == []
    (suspect,) = suspects(shown(*slow, *fast, ((1.25,), "GoFast")), [METERS], NAMES)
    assert (suspect.examples, suspect.instead, suspect.corrections) == ((13,), "GoSlow", ())
    assert suspects(shown(*slow, *fast, ((3.5,), "GoFast")), [METERS]) == []


def test_of_two_that_contradict_each_other_alone_neither_is_removed():
    pair = shown(((1.0,), "GoSlow"), ((1.0,), "GoFast"))
    assert suspects(pair, [METERS]) == []
    assert contradictions([*pair, *shown(((2.0,), "GoFast"), numbered_from=3)]) == [pair]


def test_the_same_input_gives_the_same_proposals_whatever_the_order_of_examples():
    told = [to_slow(1.7), to_slow(1.5)]
    first = propose(APPROACH, [METERS], told)
    again = propose(APPROACH[::-1], [METERS], told)
    assert [(p.kind, p.examples) for p in first] == [(p.kind, p.examples) for p in again]
    assert [p.score for p in first] == pytest.approx([p.score for p in again])


def test_examples_and_corrections_that_lack_values_are_named():
    with pytest.raises(TrainingError, match="example 3 has 1 value for 2 features"):
        propose(APPROACH[2:], [METERS, METERS], [])
    with pytest.raises(TrainingError, match="correction 1 has 2 values for 1 feature"):
        propose([], [METERS], [Correction("Start", (1.0, 2.0), "Start", "Stop")])
