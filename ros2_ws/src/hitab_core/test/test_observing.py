"""Observers are guests: with and without them an agent reads, draws and does the same."""

from __future__ import annotations

import logging
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_core.automaton import START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature, FeatureKind
from hitab_core.learning.transition_learning import learner
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.repertoire import Repertoire
from hitab_core.running import RunContext, performance
from hitab_core.running.feature_cache import FeatureCache
from hitab_core.running.live_features import live_features
from hitab_core.running.observing import Change, guest
from hitab_core.term import Term
from hitab_core.transition_function import HandWritten, TransitionFunction

NAMES = ("First", "Second", "Third")
STATES = ("A", "B", "C")
NEAREST = "sklearn.neighbors.KNeighborsClassifier(n_neighbors=2)"


def learn_transition(classifier, scales, X, y, default=None, names=None):
    """Learn the transition function of one state; by default no example is a default one."""
    return learner(classifier, scales, names)(X, y, default or [False] * len(y))


class Touchy:
    """A body that writes down each reading, which changes it; a negative value cannot be read."""

    def __init__(self) -> None:
        self.values: Sequence[float] = (0.0, 0.0, 0.0)
        self.log: list[str] = []
        self.offset = 0.0

    def read(self, column: int) -> float:
        self.log.append(f"read {NAMES[column]}")
        self.offset = (self.offset + 0.5) % 3.0
        if self.values[column] < 0:
            raise ZeroDivisionError(NAMES[column])
        return self.values[column] + self.offset


def behavior(name: str) -> BasicBehavior:
    def note(what: str) -> Callable[[Touchy], None]:
        return lambda body: body.log.append(f"{what} {name}")

    return BasicBehavior(name, note("pulse"), note("start"), note("stop"))


DOMAIN = Domain.of(
    "touchy",
    "1",
    lambda name: Touchy(),
    behaviors=[behavior(name) for name in STATES],
    features=[Feature(name, lambda body, i=i: body.read(i)) for i, name in enumerate(NAMES)],
)
SCALES = [DOMAIN.features[name].scale for name in NAMES]


class Chooses(dict[tuple[float, ...], str]):
    """What a programmer's function chooses, which depends on how often it was called."""

    def __init__(self) -> None:
        super().__init__()
        self.calls = 0

    def __call__(self, value: float) -> str:
        self.calls += 1
        return STATES[(self.calls + int(value)) % 3]


rows = st.lists(
    st.tuples(st.tuples(*[st.integers(0, 5).map(float)] * 3), st.sampled_from(STATES)),
    min_size=2,
    max_size=6,
)


@st.composite
def functions(draw: st.DrawFn) -> Callable[[], TransitionFunction]:
    """Return what makes the same transition function again and again."""
    kind = draw(st.sampled_from(["tree", "tree", "tree", NEAREST, "hand-written"]))
    if kind == "hand-written":
        return lambda: HandWritten(Chooses(), (1,))
    taught = draw(rows)
    X, y = [list(values) for values, _ in taught], [label for _, label in taught]
    return lambda: learn_transition(kind, SCALES, X, y)


class Player:
    """An agent with two levels, of which ``observe`` sees all changes."""

    def __init__(
        self,
        inner: dict[str, TransitionFunction],
        outer: dict[str, TransitionFunction],
        observe: Callable[[Change], None] | None,
        most_probable: bool,
    ) -> None:
        terms = tuple(map(Term, NAMES))
        self.repertoire = Repertoire(
            DOMAIN,
            {
                "Inner": Automaton("Inner", tuple(map(Term, STATES)), terms, inner),
                "Outer": Automaton(
                    "Outer",
                    (Term("Inner"), Term("A")),
                    terms,
                    {state: _Through(f) for state, f in outer.items()},
                ),
            },
        )
        self.body = Touchy()
        self.random = random.Random(5)
        self.feature_cache = FeatureCache(self.body, DOMAIN)
        self.context = RunContext(
            self.repertoire,
            self.body,
            self.feature_cache,
            self.random.random,
            most_probable,
            observe,
        )
        self.running = performance(self.context, Term("Outer"))
        self.running.start()

    def tick(self, values: Sequence[float]) -> None:
        self.body.values = values
        self.feature_cache.forget()
        try:
            self.running.tick()
        except ZeroDivisionError as error:
            self.body.log.append(repr(error))

    @property
    def done(self) -> tuple[Any, ...]:
        return self.body.log, self.body.offset, self.random.getstate(), self.running.active_path


class _Through:
    """A function of the outer automaton: where another one says B or C, go inside."""

    def __init__(self, function: TransitionFunction) -> None:
        self._function = function
        self.features_used = function.features_used

    def compile(self, slots: Any, states: Any, *, most_probable: bool = False) -> Any:
        inside = {"A": states["A"], "B": states["Inner"], "C": states["Inner"]}
        return self._function.compile(slots, inside, most_probable=most_probable)

    def explain(self, values: Any, names: Any) -> Any:
        return self._function.explain(values, names)

    def retrace(self, values: Any, names: Any) -> Any:
        return self._function.retrace(values, names)


def looks(change: Change) -> None:
    """Look at all that an observer can see."""
    why = change.explanation()
    assert why is not None
    assert why.distribution.get(change.destination, 1.0) > 0, "what was chosen was possible"
    assert all(change.values[i] is not None for i in why.features)


def fails(change: Change) -> None:
    raise RuntimeError("an observer that fails")


@settings(max_examples=60)
@given(data=st.data())
def test_with_and_without_observers_an_agent_reads_draws_and_does_the_same(
    data: st.DataObject,
) -> None:
    """Without the record an observer reads what no decision read, and raises into the tick."""
    inner = {state: data.draw(functions()) for state in (START, *STATES)}
    outer = {state: data.draw(functions()) for state in (START, "Inner", "A")}
    most_probable = data.draw(st.booleans())
    percepts = data.draw(
        st.lists(st.tuples(*[st.sampled_from([-1.0, 0.0, 1.0, 4.0])] * 3), min_size=3, max_size=12)
    )
    seen: list[Change] = []

    def watches(change: Change) -> None:
        looks(change)
        seen.append(change)

    wrong: list[Exception] = []

    def strictly(change: Change) -> None:
        try:
            watches(change)
        except Exception as error:
            wrong.append(error)

    alone, watched, failing = (
        Player(
            {state: make() for state, make in inner.items()},
            {state: make() for state, make in outer.items()},
            observe,
            most_probable,
        )
        for observe in (None, strictly, fails)
    )
    for values in percepts:
        for player in (alone, watched, failing):
            player.tick(values)
        assert watched.done == failing.done == alone.done
    assert not wrong, "an explanation needs nothing that the decision did not read"
    entered = [line for line in alone.body.log if line.startswith("start")]
    assert len(seen) >= len(entered)


def test_an_explanation_of_a_hand_written_function_does_not_call_it_again() -> None:
    chooses = Chooses()
    why = HandWritten(chooses, (0,)).retrace([1.0], ["x"])
    assert (why.tests, why.features, chooses.calls) == (("hand-written",), (0,), 0)


def test_an_explanation_of_a_classifier_does_not_predict_again() -> None:
    function: Any = learn_transition(
        NEAREST, SCALES[:1], [[0.0], [1.0], [4.0], [5.0]], ["A", "A", "B", "B"]
    )
    predictions: list[Any] = []
    choose = function.predicts.choose
    watched = replace(
        function.predicts, choose=lambda *row: predictions.append(row) or choose(*row)
    )
    function = replace(function, predicts=watched)
    decide = function.compile([0], {"A": 0, "B": 1})
    assert decide([4.6], lambda slot: math.nan, lambda: 0.9) == 1
    assert len(predictions) == 1
    assert function.retrace([4.6], ["x"]).features == (0,)
    assert function.retrace([None], ["x"]).features == ()
    assert len(predictions) == 1


def test_an_explanation_ends_where_a_value_is_missing() -> None:
    tree = TransitionTree(SCALES[:2]).fit(
        [[0.0, 0.0], [0.0, 4.0], [4.0, 0.0], [4.0, 4.0]], ["A", "B", "C", "C"]
    )
    assert tree.retrace([4.0, None], "xy").distribution == {"C": 1.0}
    cut = tree.retrace([0.0, None], "xy")
    assert (cut.features, cut.distribution) == ((0,), {"A": 0.5, "B": 0.5})
    assert len(cut.tests) == 1
    assert tree.retrace([None, None], "xy").tests == ()


def test_an_observer_that_fails_is_logged_once_and_called_again(
    caplog: pytest.LogCaptureFixture,
) -> None:
    calls = []

    def fails(seen: int) -> None:
        calls.append(seen)
        raise KeyError("missing key")

    observe = guest(fails)
    assert guest(observe) is observe
    with caplog.at_level(logging.WARNING):
        observe(1)
        observe(2)
    assert calls == [1, 2]
    assert len(caplog.records) == 1
    assert "missing key" in caplog.text


# Asked by people --------------------------------------------------------------------------------


def asked(kind: FeatureKind = FeatureKind.CONTINUOUS) -> Player:
    goes = HandWritten(lambda value: "A" if value > 2.0 else "B", (0,))
    return Player({}, {START: goes}, None, False)


def test_what_people_ask_is_not_kept_for_a_decision() -> None:
    """Kept in its slot, what was read for people would be what the decision goes by."""
    player = asked()
    player.body.values = (1.0, 0.0, 0.0)
    player.feature_cache.forget()
    assert live_features(player.running, player.context)[0] == ("Outer", "First", 1.5)
    player.body.values = (3.0, 0.0, 0.0)  # a feature may change without a percept
    player.running.tick()
    assert player.running.active_path[0] == "A"


def test_the_values_that_a_decision_has_read_are_reported_as_read() -> None:
    player = asked()
    player.tick((3.0, 0.0, 0.0))
    player.body.log.clear()
    readings = live_features(player.running, player.context)
    assert readings[0] == ("Outer", "First", 3.5)
    assert player.body.log == [f"read {name}" for name in NAMES[1:]]


def test_one_feature_that_cannot_be_read_hides_no_other_and_raises_nothing() -> None:
    player = asked()
    player.body.values = (1.0, -1.0, 2.0)
    player.feature_cache.forget()
    also = [Term("Second"), Term("Third")]
    values = [value for _, _, value in live_features(player.running, player.context, also)]
    assert [math.isnan(value) for value in values] == [False, True, False, True, False]


def test_the_record_of_a_change_tells_the_path_and_what_was_read() -> None:
    seen: list[Change] = []
    goes = TransitionTree(SCALES).fit([[0, 0, 0], [4, 0, 0]], ["A", "B"])
    player = Player({START: goes}, {START: HandWritten(lambda: "B", ())}, seen.append, False)
    player.tick((4.0, -1.0, -1.0))
    outer, inner = seen
    assert (outer.automata, outer.source, outer.destination) == (("Outer",), START, "Inner")
    assert (inner.automata, inner.destination) == (("Outer", "Inner"), "B")
    assert (list(inner.values), inner.commanded) == ([4.5, None, None], False)
    assert inner.features == list(NAMES)
