"""Kinds of commanders: what is written is read again, errors have places, words a meaning."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_commander.aggregation import observed, of_positions, summed_up
from hitab_commander.commander_body import CommanderBody
from hitab_commander.commander_domain import commander_domain
from hitab_commander.kinds.kind import CommanderKind, Observation, OrderMap, Over, Pick
from hitab_commander.kinds.kind_reader import described_kind, kind_text, read_kind
from hitab_core import Automaton, BehaviorLibrary, LibraryError, Scale, Term
from hitab_core.example import Example
from hitab_core.learning.transition_learning import learn_transitions
from hitab_core.library.yaml_places import read_yaml
from hitab_core.orders.order import ALL_OTHERS, Order, Report
from hitab_core.texts.errors import VocabularyError

NAMES = st.from_regex(r"[A-Z][a-z]{0,6}", fullmatch=True).filter(
    lambda name: name not in ("Done", "Failed", "Start")
)
VALUES = st.floats(-1e6, 1e6)
MAYBE = st.one_of(VALUES, st.just(math.nan))
LIMITS = st.one_of(st.none(), VALUES)
USES = st.one_of(NAMES, NAMES.map(lambda name: f"{name}(ball)"))
ROLES = st.from_regex(r"[a-z]{1,5}", fullmatch=True)
SUMS = [over.value for over in Over if over not in (Over.VALUE, Over.GROUP)]
RECEIVED = st.one_of(st.sampled_from(["keep", "nothing"]), USES)


def named(values: st.SearchStrategy) -> st.SearchStrategy:
    return st.dictionaries(NAMES, values, max_size=4)


def one_of(overs: list[str], observed: st.SearchStrategy, **more: st.SearchStrategy):
    """Return lines that observe something, with further keys or without."""
    made = st.tuples(st.sampled_from(overs), observed, st.fixed_dictionaries({}, optional=more))
    return made.map(lambda parts: {parts[0]: parts[1], **parts[2]})


FLAGS_AND_STATES = st.one_of(
    st.sampled_from(["Done", "Failed"]), NAMES.map(lambda state: {"active": state})
)
KINDS = st.fixed_dictionaries(
    {
        "orders": st.dictionaries(
            NAMES,
            st.one_of(RECEIVED, st.dictionaries(ROLES, RECEIVED, min_size=1, max_size=3)),
            min_size=1,
            max_size=4,
        ),
        "features": named(
            st.one_of(
                one_of(SUMS, FLAGS_AND_STATES, role=ROLES),
                one_of(SUMS, USES, role=ROLES, below=VALUES, above=VALUES),
            )
        ),
        "targets": named(
            st.one_of(
                one_of(["minimum", "maximum"], USES, role=ROLES),
                one_of(["number"], st.integers(1, 9), role=ROLES),
            )
        ),
    }
)


@given(NAMES, KINDS)
def test_what_is_written_is_read_again_and_means_the_same(name, described):
    kind = described_kind(name, described)
    again = described_kind(name, read_yaml(kind_text(kind), "x").value)
    assert again == kind
    assert commander_domain(again).version == commander_domain(kind).version


def kind_of(text: str, tmp_path: Path) -> CommanderKind:
    (tmp_path / "kind.yaml").write_text(text)
    return read_kind(tmp_path / "kind.yaml")


def test_a_domain_depends_on_the_kind_alone_and_its_version_on_what_the_words_mean(tmp_path):
    text = "commander: Squad\norders: {Go: Search}\nfeatures: {Far: {mean: X}}\n"
    first = commander_domain(kind_of(text, tmp_path))
    slower = commander_domain(kind_of(text + "rate: 2\n", tmp_path))
    other = commander_domain(kind_of(text.replace("mean", "maximum"), tmp_path))
    assert (first.name, first.signature, first.version) == (
        slower.name,
        slower.signature,
        slower.version,
    )
    assert other.signature == first.signature
    assert other.version != first.version


def test_what_a_commander_has_learned_outlasts_new_orders_and_features_beside_those_it_uses(
    tmp_path,
):
    text = "commander: Squad\norders: {Go: Search, Rest: nothing}\nfeatures: {Far: {mean: X}}\n"
    examples = (Example("Start", (1.0,), "Go", number=1, command=1),)
    learned = learn_transitions(examples, [Scale()])
    lead = Automaton("Lead", (Term("Go"),), (Term("Far"),), learned, examples=examples)

    def library(text: str) -> BehaviorLibrary:
        return BehaviorLibrary(tmp_path / "library", commander_domain(kind_of(text, tmp_path)))

    library(text).save(lead)
    more = text.replace("nothing}", "Stop, Home: Home}").replace("}}", "}, Near: {minimum: X}}")
    assert list(library(more).load()) == ["Lead"]
    for changed in (text.replace("Search", "Find"), text.replace("mean", "maximum")):
        with pytest.raises(LibraryError, match="of its parts"):
            library(changed).load()


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("orders: {Go: 3}", ":2: `Go:` must be a behavior, `nothing` or `keep`, not 3"),
        ("orders: {Go: 'a b'}", '"a b" is not a use of a behavior'),
        ("orders: {Go(A): Search}", "is about A; say what A and the others do"),
        ("orders: {'Go(A, B)': {A: X}}", "has 2 parameters; leave one"),
        ("orders: {Go(A): {A: X}, Go: Y}", 'has "Go" twice; rename one'),
        ("features: {F: {avg: X}}", ":2: `F:` has no known kind"),
        ("features: {F: {value: X}}", '"F" is the value of one subordinate: write `F(A):`'),
        ("features: {F(A): {mean: X}}", '"F(A)" is about all subordinates: write `F:` without'),
        ("features: {F: {any: {state: X}}}", "`state:` is not known here (known: active)"),
        ("features: {F: {any: {active: X}, below: 3}}", "`below:` and `above:` are for features"),
        ("features: {F: {group: z}}", "which is not known (known: spread, x, y)"),
        ("targets: {t(A): {number: 1}}", "a target has no parameter: write `t:`"),
        ("targets: {t: {number: 0}}", "`number:` must be at least 1, not 0"),
        ("rate: 0", "`rate:` must be at least 1e-06, not 0"),
        ("order: {}", "`order:` is not known here (known: commander, deadline"),
    ],
)
def test_what_is_wrong_with_a_kind_is_told_with_its_place(tmp_path, line, expected):
    with pytest.raises(VocabularyError) as error:
        kind_of(f"commander: Squad\n{line}\n", tmp_path)
    assert str(error.value).startswith(f"{tmp_path}/kind.yaml:")
    assert expected in str(error.value)


# -- aggregation --------------------------------------------------------------------------------


@given(st.lists(st.booleans()))
def test_any_all_fraction_and_count_ask_something_of_each(answers):
    values = [float(answer) for answer in answers]
    assert summed_up(values, Over.ANY) == any(answers)
    assert summed_up(values, Over.ALL) == (all(answers) and bool(answers))
    assert summed_up(values, Over.COUNT) == sum(answers)
    if answers:
        assert summed_up(values, Over.FRACTION) == pytest.approx(sum(answers) / len(answers))
    else:
        assert summed_up(values, Over.FRACTION) == 0.0


@given(st.lists(VALUES, min_size=1), st.randoms())
def test_mean_minimum_and_maximum_do_not_depend_on_the_order_and_leave_out_who_has_no_value(
    values, random
):
    shuffled = [*values, math.nan, math.nan]
    random.shuffle(shuffled)
    for over in (Over.MEAN, Over.MINIMUM, Over.MAXIMUM):
        assert summed_up(shuffled, over) == summed_up(values, over)
    mean = summed_up(values, Over.MEAN)
    assert min(values) - 1e-6 <= mean <= max(values) + 1e-6


def test_of_nobody_a_mean_minimum_or_maximum_has_no_value():
    for over in (Over.MEAN, Over.MINIMUM, Over.MAXIMUM):
        assert math.isnan(summed_up([math.nan], over))
    assert math.isnan(of_positions("spread", [()]))


@given(
    st.lists(st.tuples(VALUES, VALUES), min_size=1, max_size=20),
    st.tuples(VALUES, VALUES),
)
def test_the_spread_stays_the_same_wherever_the_group_is(points, by):
    moved = [(x + by[0], y + by[1]) for x, y in points]
    assert of_positions("spread", moved) == pytest.approx(of_positions("spread", points), abs=1e-3)
    assert of_positions("spread", [points[0]]) == 0.0


@given(MAYBE, LIMITS, LIMITS)
def test_limits_make_a_question_of_a_value(value, below, above):
    report = Report("a", 7, 1, values=(value,))
    seen = observed(report, Observation(feature="X", below=below, above=above), ("X",), (7, 1))
    if math.isnan(value):
        assert math.isnan(seen)
    elif below is None and above is None:
        assert seen == value
    else:
        inside = (below is None or value < below) and (above is None or value > above)
        assert seen == inside


def test_values_of_an_earlier_epoch_and_flags_of_an_earlier_order_do_not_count():
    report = Report("a", 7, 1, flags=("Done",), values=(3.0,))
    value, flag = Observation(feature="X"), Observation(flag="Done")
    assert observed(report, value, ("X",), (7, 2)) == 3.0
    assert math.isnan(observed(report, value, ("X",), (8, 1)))
    assert observed(report, flag, (), (7, 1)) == 1.0
    assert observed(report, flag, (), (7, 2)) == 0.0


# -- orders -------------------------------------------------------------------------------------


@given(
    st.dictionaries(st.sampled_from(["", "scout", "a", "b"]), NAMES),
    st.sampled_from(["a", "b", "c"]),
    st.sampled_from(["", "scout", "carrier"]),
)
def test_an_order_means_what_it_says_for_the_name_else_the_role_else_all(behaviors, name, role):
    found = Order(behaviors=behaviors).behavior_for(name, role)
    expected = [behaviors[key] for key in (name, role, ALL_OTHERS) if key in behaviors]
    assert found == (expected[0] if expected else None)


def body_with(values: dict[str, float]) -> CommanderBody:
    pick = Pick("least", Over.MINIMUM, Observation(feature="X"))
    body = CommanderBody("chief", CommanderKind("Squad", (), (), (pick,), deadline=1.0))
    body.enlist(dict.fromkeys(values, ""), 7)
    for name, value in values.items():
        body.hear(Report(name, 7, 0, values=(value,)), 0.0)
    return body


@given(st.dictionaries(st.sampled_from("abcdef"), MAYBE))
def test_the_picked_subordinate_has_the_least_value_and_is_the_first_of_equals(values):
    body = body_with(values)
    picked = body.picked(body.kind.targets[0])
    known = {name: value for name, value in values.items() if not math.isnan(value)}
    assert picked == (min(known, key=lambda name: known[name]) if known else None)


def test_who_is_silent_is_not_picked_and_nobody_left_leaves_nothing_to_command():
    body = body_with({"a": 1.0, "b": 2.0})
    pick = body.kind.targets[0]
    assert body.picked(pick) == "a"
    body.hear(Report("b", 7, 0, values=(2.0,)), 0.9)
    body.now = 1.5
    assert body.picked(pick) == "b"
    assert body.fraction_silent == 0.5
    assert body.ready
    body.now = 3.0
    assert not body.ready


def test_giving_the_order_in_force_again_gives_nothing():
    body = body_with({"a": 1.0})
    given_orders = []
    body.on_order = given_orders.append
    order = OrderMap("Send", {"A": "Search", ALL_OTHERS: None}, "A")
    body.give(order, "a")
    body.give(order, "a")
    body.give(order, None)
    assert [(o.name, dict(o.behaviors), o.sequence) for o in given_orders] == [
        ("Send(a)", {"a": "Search"}, 1)
    ]
