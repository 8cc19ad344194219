"""What an agent asks about the examples of a training, and what the answers do."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hitab_core import (
    Agent,
    BehaviorLibrary,
    Domain,
    Feature,
    FeatureKind,
    Target,
    Term,
    TrainingError,
    plain_domain,
)
from hitab_core.assistant import Question, training_costs
from hitab_core.assistant.doubts import Doubt, doubtful
from hitab_core.assistant.lateness import LateCommand
from hitab_core.example import Example, ExampleKind, contradictions
from hitab_core.training import Curriculum, percepts

CART = plain_domain(
    "cart",
    {"Left": [-1.0], "Right": [1.0], "Stop": [0.0]},
    {"Position": lambda p: p[0], "Bump": lambda p: p[1]},
)


class Driven:
    """A cart that gets its position as a percept."""

    def __init__(self, folder: Path, *features: str, domain: Domain = CART) -> None:
        self.folder = folder
        self.domain = domain
        self.cycle = 0
        self.agent = self.made()
        self.agent.begin(Curriculum("Shuttle", tuple(map(Term, features or ("Position",)))))

    def made(self) -> Agent:
        library = BehaviorLibrary(self.folder / "library", self.domain)
        return Agent("cart", self.domain, library, self.folder / "journal")

    @property
    def session(self):
        assert self.agent.session is not None
        return self.agent.session

    def at(self, position: float, bump: float = 0.0) -> None:
        self.cycle += 1
        self.agent.sense([position, bump], [], self.cycle, self.cycle * 0.1)
        self.agent.tick()

    def show(self, position: float, label: str, bump: float = 0.0) -> None:
        self.at(position, bump)
        self.agent.command(Term(label))

    def asked(self, kind: str) -> Question:
        """Return the question of a kind, after dismissing those before it."""
        while (question := self.session.questions.find()[0]).kind != kind:
            self.session.answer(question.number, dismiss=True)
        return question

    def kinds(self) -> list[str]:
        return [question.kind.value for question in self.session.questions.find()]


@pytest.fixture
def cart(tmp_path: Path) -> Driven:
    return Driven(tmp_path)


def twice(cart: Driven) -> None:
    """Contradict oneself: in Right at 5, first Left, then Stop."""
    cart.show(0.0, "Right")
    cart.show(5.0, "Left")
    cart.show(0.0, "Right")
    cart.show(5.0, "Stop")


def test_nothing_is_asked_before_the_first_command(cart: Driven) -> None:
    cart.at(1.0)
    assert cart.kinds() == []
    cart.show(2.0, "Right")
    cart.session.undo()
    cart.at(3.0)
    assert cart.kinds() == []


def test_commands_that_contradict_each_other_are_asked_about_at_once(cart: Driven) -> None:
    twice(cart)
    assert len(cart.session.questions.known()) == 1
    (question, *_) = cart.session.questions.find()
    assert question.kind == "contradiction"
    assert question.examples == (3, 7)
    assert [choice.name for choice in question.choices] == ["Stop", "Left"]
    cart.session.answer(question.number, "Stop")
    assert [e.number for e in cart.session.examples] == [1, 2, 5, 6, 7, 8], "with its default one"
    assert [(cost.proposals, cost.finished) for cost in training_costs(cart.agent.journal)] == [
        (0, False)
    ], "nothing speaks for either"
    assert "contradiction" not in cart.kinds()
    cart.session.undo()
    assert "contradiction" in cart.kinds(), "undo asks again"


def test_contradictions_are_between_ordinary_examples_of_one_state_with_all_values_equal() -> None:
    nan = math.nan
    rows = [((0.0, nan), "Stop"), ((-0.0, nan), "Left"), ((0.0, 1.0), "Right")]
    there = [Example("Right", values, to, number=n) for n, (values, to) in enumerate(rows, 1)]
    default = Example("Right", (0.0, 1.0), "Right", ExampleKind.DEFAULT, 9)
    elsewhere = Example("Start", (0.0, 1.0), "Left", number=10)
    assert contradictions([*there, default, elsewhere]) == [there[:2]]


def test_a_training_without_features_can_be_asked_about(cart: Driven) -> None:
    cart.agent.begin(Curriculum("Blind", ()))
    for _ in range(2):
        twice(cart)
    cart.agent.test()
    cart.at(0.0)
    cart.agent.take_over()
    wrong = cart.session.running.active
    cart.agent.command(Term("Right" if wrong != "Right" else "Left"))
    while questions := cart.session.questions.find():
        assert "where ," not in str(questions)
        cart.session.answer(questions[0].number)


@pytest.mark.parametrize("features", [(), ("Position",)])
def test_a_training_without_examples_has_no_question(cart: Driven, features: tuple[str]) -> None:
    cart.agent.begin(Curriculum("Blank", tuple(map(Term, features))))
    assert cart.session.questions.find() == []


def test_an_answer_is_given_once_and_to_a_question_that_is_open(cart: Driven) -> None:
    twice(cart)
    (question, *_) = cart.session.questions.find()
    with pytest.raises(TrainingError, match=r'has no choice "Wait" \(known: Left, Stop\)'):
        cart.session.answer(question.number, "Wait")
    with pytest.raises(TrainingError, match=r"is proposed.*choose one of: Stop, Left"):
        cart.session.answer(question.number)
    cart.session.answer(question.number, "Left")
    with pytest.raises(TrainingError, match=f"question {question.number} is no longer open"):
        cart.session.answer(question.number, "Left")
    with pytest.raises(TrainingError, match="no question 99"):
        cart.session.answer(99)


def test_a_question_that_was_dismissed_is_not_asked_again_also_after_a_crash(
    cart: Driven,
) -> None:
    twice(cart)
    (question, *_) = cart.session.questions.find()
    cart.session.answer(question.number, dismiss=True)
    assert "contradiction" not in cart.kinds()
    cart.agent.journal.close()
    cart.agent = cart.made()
    assert "contradiction" not in cart.kinds()
    assert len(cart.session.examples) == 8


def test_two_older_commands_outweigh_a_newer_one_but_not_a_correction(cart: Driven) -> None:
    def proposed() -> str:
        (question,) = [q for q in cart.session.questions.find() if q.kind == "contradiction"]
        return question.proposed

    for label in ("Left", "Left", "Stop"):
        cart.show(0.0, "Right")
        cart.show(5.0, label)
    assert proposed() == "Left"
    cart.session.undo()
    cart.agent.test()
    cart.agent.take_over()
    cart.show(0.0, "Right")
    cart.show(5.0, "Stop")
    assert proposed() == "Stop", "the person has seen what the others led to"
    cart.show(0.0, "Right")
    cart.agent.test()
    cart.agent.take_over()
    cart.show(5.0, "Left")
    assert proposed() == "Left"


def confused(folder: Path) -> Driven:
    """Give rise to questions of several kinds."""
    cart = Driven(folder, "Position", "Bump")
    cart.show(0.0, "Right")
    cart.at(2.0)
    cart.at(9.0)
    cart.at(3.0, 1.0)
    cart.show(5.0, "Stop", bump=1.0)
    for label in ("Left", "Right"):
        cart.show(7.0, "Stop")
        cart.show(8.0, label)
    cart.agent.test(restart=True)
    cart.at(0.0)
    cart.at(4.0)
    cart.agent.take_over()
    cart.agent.command(Term("Left"))
    return cart


def test_questions_are_looked_for_in_steps_and_the_same_are_found(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    cart, other = confused(tmp_path / "a"), confused(tmp_path / "b")
    steps = sum(1 for _ in cart.session.search())
    assert steps > 5
    assert [q.text for q in cart.session.questions.find()] == [
        q.text for q in other.session.questions.find()
    ]
    assert sum(1 for _ in cart.session.search()) == 0, "they are known"


def test_a_search_during_which_the_examples_change_finds_nothing(tmp_path: Path) -> None:
    cart = confused(tmp_path)
    search = cart.session.search()
    next(search)
    cart.show(1.0, "Right")
    count = len(cart.session.questions.known())
    assert list(search) == []
    assert len(cart.session.questions.known()) == count
    assert len(cart.session.questions.find()) > count


def test_a_feature_that_is_not_read_cannot_be_chosen_before_the_first_example(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a domain with very many features, those of two parameters are read only if chosen."""
    monkeypatch.setattr(percepts, "READABLE_MAX", 0)
    domain = Domain.of(
        "pair",
        "1",
        CART.body,
        behaviors=CART.behaviors.values(),
        features=[Feature("Between", lambda body, a, b: 1.0, parameters=("A", "B"))],
        targets=[Target("ball", lambda body: None), Target("goal", lambda body: None)],
    )
    agent = Agent("ann", domain, BehaviorLibrary(tmp_path / "library", domain), tmp_path)
    session = agent.begin(Curriculum("Look", ()))
    with pytest.raises(TrainingError, match=r"Between\(ball, goal\) cannot be chosen any more"):
        session.choose_features([Term.parse("Between(ball, goal)")])
    session = agent.begin(Curriculum("Look", (Term.parse("Between(ball, goal)"),)))
    agent.sense([0.0], [], 1, 0.1)
    agent.command(Term("Right"))
    assert session.examples[0].features == (1.0,)


@pytest.fixture
def shown(tmp_path: Path) -> Driven:
    """A cart that was shown to go right at 0 and to stop at 5, without a bump."""
    cart = Driven(tmp_path, "Position", "Bump")
    cart.show(0.0, "Right")
    cart.show(5.0, "Stop")
    return cart


def never_shown(cart: Driven) -> Question | None:
    """Return what is asked about something that was never shown."""
    return next((q for q in cart.session.questions.find() if q.kind == "unshown"), None)


def test_a_situation_that_is_met_in_a_test_is_asked_about_and_the_answer_is_learned(
    shown: Driven,
) -> None:
    shown.agent.test(restart=True)
    for position in (0.0, 1.0, 2.0):
        shown.at(position)
    shown.at(2.5, bump=1.0)
    about = []
    while (question := never_shown(shown)) is not None:
        about.append((question.state, question.situation))
        assert question.text.partition("?")[2].startswith(" Nothing like it was shown; as it is, ")
        position, bump = question.situation
        shown.session.answer(question.number, "Stop" if bump or position > 3.0 else "Right")
    assert ("Right", (2.5, 1.0)) in about
    assert len(about) == len(set(about)), "an answer ends its question"
    function = shown.session.automaton().transitions["Right"]
    assert list(function.predict([[2.5, 1.0], [2.0, 0.0], [5.0, 0.0]])) == [
        "Stop",
        "Right",
        "Stop",
    ]


@pytest.mark.parametrize(
    ("position", "proposed"), [(3.0, "Right"), (4.5, ""), (7.0, ""), (15.0, "Stop")]
)
def test_a_decision_is_proposed_where_examples_of_others_are_twice_as_far(
    cart: Driven, position: float, proposed: str
) -> None:
    cart.show(0.0, "Right")
    cart.show(10.0, "Stop")
    cart.agent.test(restart=True)
    cart.at(0.0)
    cart.at(position)
    asked = {q.state: q for q in cart.session.questions.find() if q.kind == "unshown"}["Right"]
    assert asked.situation == (position,)
    assert asked.choices[0].name == ("Right" if position < 10.0 else "Stop"), "as it is"
    assert asked.proposed == proposed
    if proposed:
        cart.session.answer(asked.number)
        assert cart.session.examples[-1].next_state == proposed
    else:
        with pytest.raises(TrainingError, match=r"no answer .* is proposed"):
            cart.session.answer(asked.number)
    assert [cost.proposals for cost in training_costs(cart.agent.journal)] == [bool(proposed)]


def test_what_was_shown_is_not_asked_about(shown: Driven) -> None:
    for _ in range(20):
        shown.show(0.0, "Right")
        shown.show(0.0, "Right")
        shown.show(5.0, "Stop")
        shown.show(5.0, "Stop")
    while (question := never_shown(shown)) is not None:
        assert question.state not in ("Right", "Stop"), question.text
        shown.session.answer(question.number, dismiss=True)


def test_a_state_that_no_example_leaves_is_asked_about(shown: Driven) -> None:
    shown.agent.test(restart=True)
    for position in (0.0, 5.0, 5.0, 9.0):
        shown.at(position)
    states = []
    while (question := never_shown(shown)) is not None:
        states.append(question.state)
        shown.session.answer(question.number, dismiss=True)
    assert "Stop" in states


def test_a_boolean_is_asked_about_that_never_changed_in_a_state_that_nothing_leaves(
    tmp_path: Path,
) -> None:
    bump = Feature("Bump", lambda body: body.percept[1], FeatureKind.BOOLEAN)
    position = Feature("Position", lambda body: body.percept[0])
    domain = plain_domain("cart", {"Right": [1.0], "Stop": [0.0]}, [position, bump])
    driven = Driven(tmp_path, "Position", "Bump", domain=domain)
    driven.show(0.0, "Stop")
    driven.show(1.0, "Right")
    asked = []
    while (question := never_shown(driven)) is not None:
        asked.append(question)
        driven.session.answer(question.number, dismiss=True)
    bumps = [(q.state, q.situation, q.cycle) for q in asked if q.situation[1]]
    assert bumps == [("Right", (1.0, 1.0), 0)], "Stop is left, and in Right there was no bump"


def turret(folder: Path) -> Driven:
    """Return what fires or waits by a bearing."""
    bearing = Feature("Bearing", lambda body: body.percept[0], FeatureKind.TOROIDAL, period=360.0)
    domain = plain_domain("turret", {"Wait": [0.0], "Fire": [1.0]}, [bearing])
    return Driven(folder, "Bearing", domain=domain)


def test_an_answer_overrules_what_was_taken_for_granted_there_on_both_halves_of_a_circle(
    tmp_path: Path,
) -> None:
    driven = turret(tmp_path)
    driven.show(90.0, "Wait")
    driven.show(-3.0, "Fire")
    while (question := never_shown(driven)) is not None and question.state != "Fire":
        driven.session.answer(question.number, dismiss=True)
    assert question is not None
    assert question.situation == (-3.0,)
    (choice,) = [choice for choice in question.choices if choice.name == "Wait"]
    assert choice.effect.endswith("; in Fire with Bearing = -3: Wait instead of stay")
    driven.session.answer(question.number, "Wait")
    assert list(driven.session.automaton().transitions["Fire"].predict([[-3.0]])) == ["Wait"]
    assert [e.number for e in driven.session.examples if not e.is_learned] == [4]


@pytest.mark.parametrize(("before", "last"), [(10.0, 180.0), (30.0, -20.0)])
def test_one_question_tells_how_far_a_side_of_a_circle_goes(
    tmp_path: Path, before: float, last: float
) -> None:
    driven = turret(tmp_path)

    def meant(place: float) -> str:
        return "Fire" if min(20, last) <= (place + 90) % 360 - 90 <= max(20, last) else "Wait"

    driven.show(before, "Wait")
    driven.show(20.0, "Fire")
    driven.show(before, "Wait")
    driven.agent.test(restart=True)
    for place in range(0, 360, 5):
        driven.at(place)
        driven.at(before)
    while (question := never_shown(driven)) is not None and question.state != "Wait":
        driven.session.answer(question.number, dismiss=True)
    assert question is not None
    driven.session.answer(question.number, meant(question.situation[0]))
    function = driven.session.automaton().transitions["Wait"]
    places = range(-89, 270, 2)
    learned = function.predict([[place] for place in places])
    right = sum(label == meant(place) for label, place in zip(learned, places, strict=True))
    assert right >= 0.9 * len(places)


def test_at_most_three_questions_besides_contradictions_are_asked_at_a_time(shown: Driven) -> None:
    shown.agent.test(restart=True)
    for position in (0.0, 5.0, 5.0, 9.0):
        shown.at(position)
    numbers = set()
    while questions := shown.session.questions.find():
        assert len(questions) <= 3
        matters = [question.matters for question in questions]
        assert min(matters) > 0.0, "only what changes play is asked"
        assert questions[0].number not in numbers
        numbers.add(questions[0].number)
        shown.session.answer(questions[0].number, dismiss=True)
    assert len(numbers) > 1


def test_a_question_stays_until_it_is_answered_whatever_is_met_meanwhile(shown: Driven) -> None:
    shown.agent.test(restart=True)
    shown.at(0.0)
    shown.at(1.0)
    asked, *_ = shown.session.questions.find()
    for bump in range(2, 40):  # each is met for the first time, and tells more
        shown.at(3.0, bump=float(bump))
    assert shown.session.questions.find()[0].text == asked.text
    shown.session.answer(asked.number, dismiss=True)
    other, *_ = shown.session.questions.find()
    assert other.number != asked.number


def test_each_answer_says_which_decisions_it_changes_in_all_states(cart: Driven) -> None:
    twice(cart)
    (question,) = cart.session.questions.known()
    assert [choice.effect for choice in question.choices] == [
        "deletes examples 3, 4",
        "deletes examples 7, 8",
    ], "what follows takes long to find"
    (question, *_) = cart.session.questions.find()
    assert [choice.effect for choice in question.choices] == [
        "deletes examples 3, 4; in Right with Position = 5: Stop instead of Left or Stop; "
        "in Left with Position = 5: Right instead of stay",
        "deletes examples 7, 8; in Right with Position = 5: Left instead of Left or Stop",
    ]
    assert cart.session.questions.known()[0] == question


def test_an_answer_says_what_it_changes_elsewhere_in_what_was_met(shown: Driven) -> None:
    shown.agent.test(restart=True)
    for position in (0.0, 1.0, 2.0, 2.1, 2.2):
        shown.at(position)
    while (question := never_shown(shown)) is not None and question.state != "Right":
        shown.session.answer(question.number, dismiss=True)
    assert question is not None
    effects = {choice.name: choice.effect for choice in question.choices}
    assert effects["Right"] == "adds an example: stay in Right there; changes no decision"
    assert effects["Stop"] == (
        "adds an example: go to Stop there; in Right with Position = 2.1, Bump = 0: Stop instead "
        "of stay; 1 more such decision"
    )
    met = [[position, 0.0] for position in (0.0, 1.0, 2.0, 2.1, 2.2, 5.0)]
    before = list(shown.session.automaton().transitions["Right"].predict(met))
    shown.session.answer(question.number, "Stop")
    after = list(shown.session.automaton().transitions["Right"].predict(met))
    assert sum(was != now for was, now in zip(before, after, strict=True)) == 2


def ambiguous(cart: Driven) -> None:
    """Stop where the cart is far and bumps, then meet the one without the other."""
    cart.show(0.0, "Right")
    for position in (4.0, 6.0, 8.0):
        cart.at(position)
    cart.show(5.0, "Stop", bump=1.0)


@pytest.mark.parametrize("meant", ["Position", "Bump"])
def test_which_of_two_features_is_meant_is_asked_and_the_answer_decides(
    tmp_path: Path, meant: str
) -> None:
    cart = Driven(tmp_path, "Position", "Bump")
    ambiguous(cart)
    asked = 0
    while questions := [q for q in cart.session.questions.find() if q.kind == "feature"]:
        question, asked = questions[0], asked + 1
        assert question.state == "Right"
        assert "would explain your commands as well" in question.text
        assert question.proposed == "", "nothing speaks for either"
        position, bump = question.situation
        stops = position > 2.5 if meant == "Position" else bump > 0.5
        cart.session.answer(question.number, "Stop" if stops else "Right")
    assert 1 <= asked <= 3, "each halves what is open"
    function = cart.session.automaton().transitions["Right"]
    assert function.features_used == (["Position", "Bump"].index(meant),)


def test_kinds_of_questions_are_left_out_by_name(tmp_path: Path) -> None:
    cart = Driven(tmp_path, "Position", "Bump")
    library = BehaviorLibrary(tmp_path / "other", CART)
    cart.agent = Agent(
        "cart", CART, library, tmp_path / "elsewhere", without=("feature", "unshown")
    )
    cart.agent.begin(Curriculum("Shuttle", (Term("Position"), Term("Bump"))))
    ambiguous(cart)
    assert cart.kinds() == []


def test_answers_tell_which_part_of_what_was_met_they_change_and_what_would_be_done_then(
    shown: Driven,
) -> None:
    shown.agent.test(restart=True)
    for position in (0.0, 1.0, 2.0, 2.1, 2.2):
        shown.at(position)
    cycle = shown.cycle
    while (question := never_shown(shown)) is not None and question.state != "Right":
        shown.session.answer(question.number, dismiss=True)
    assert question is not None
    assert 0 < question.cycle <= cycle
    stays, stops = (c for name in ("Right", "Stop") for c in question.choices if c.name == name)
    assert stays.changes == 0.0 < stops.changes < 1.0
    assert question.matters == stops.changes
    assert stays.states[0] == "Right"
    assert stops.states == ("Stop",)
    assert stops.cycles == (question.cycle,)
    shown.agent.go_back(question.cycle)
    again = shown.session.questions.get(question.number)
    assert (again.situation, again.cycle) == (question.situation, 0), "it will be another cycle"


@pytest.mark.parametrize("ago", ["0.00", "0.40"])
def test_a_late_command_that_may_be_meant_for_two_moments_is_asked_about(
    cart: Driven, ago: str
) -> None:
    cart.show(0.0, "Right")
    for position in (1.0, 2.0, 3.0, 4.0):
        cart.at(position)
    cart.show(5.0, "Stop")
    moments = {
        m.readings[cart.session.history.readable.index(Term("Position"))]: m
        for m in cart.session.history.since(0.0)
    }
    (example,) = [e for e in cart.session.examples if e.next_state == "Stop" and not e.is_default]
    late, other = moments[5.0], moments[1.0]
    cart.session.late.doubts[example.command] = Doubt(late.time, late, other)
    question = cart.asked("late")
    assert [choice.name for choice in question.choices] == ["0.00 s before", "0.40 s before"]
    assert question.examples == (example.number,)
    cart.session.answer(question.number, f"{ago} s before")
    assert "late" not in cart.kinds()
    (moved,) = [e for e in cart.session.examples if e.number == example.number]
    assert moved.features == ((5.0,) if ago == "0.00" else (1.0,))
    cart.session.undo()
    assert cart.session.examples[example.number - 1].features == (5.0,)


def test_a_command_is_doubtful_only_if_another_moment_is_hardly_less_probable() -> None:
    delays = np.arange(1.0, 0.0, -0.1)
    late = LateCommand("Right", "Stop", delays, np.zeros((10, 1)))
    weights = np.zeros(10)
    weights[[2, 8]] = 0.6, 0.4
    assert doubtful(late, weights, 2) == 8
    weights[[2, 8]] = 0.8, 0.2
    assert doubtful(late, weights, 2) is None
    weights[:] = 0.0
    weights[[2, 3]] = 0.5, 0.5
    assert doubtful(late, weights, 2) is None, "a person does not tell these apart"
    changed = replace(late, changed=0.8)
    assert doubtful(changed, np.append(weights, 0.9), 2) == 10, "the change of state"
