"""Undo and redo restore the examples and the state in which the next command is recorded."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from bodies import Body, noting
from hypothesis import event, given, settings
from hypothesis import strategies as st

from hitab_core.agent import Agent
from hitab_core.assistant import training_costs
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.example import Example
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.running.mode import Mode
from hitab_core.running.observing import Change
from hitab_core.term import Term
from hitab_core.texts.errors import TrainingError
from hitab_core.training import Curriculum

LASTING = ("Left", "Right", "Stay")
LABELS = (*LASTING, "Beep", "Done")


def behavior(name: str, one_shot: bool = False) -> BasicBehavior:
    return BasicBehavior(
        name, noting(name), noting(f"start-{name}"), noting(f"stop-{name}"), one_shot=one_shot
    )


DOMAIN = Domain.of(
    "line",
    "1",
    Body,
    behaviors=[*map(behavior, LASTING), behavior("Beep", one_shot=True)],
    features=[Feature("x", lambda body: body.x)],
)


class Trained:
    """An agent that is being trained; its process can be killed."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.changes: list[Change] = []
        self._start()
        self.agent.begin(Curriculum("Home", (Term("x"),)))
        self.see(0.0)

    def _start(self) -> None:
        library = BehaviorLibrary(self._folder / "library", DOMAIN)
        self.agent = Agent("ann", DOMAIN, library, self._folder, observe=self.changes.append)

    def see(self, x: float) -> None:
        self.agent.sense([x], [])

    def do(self, x: float) -> str:
        self.see(x)
        self.agent.tick()
        return self.agent.body.act()[1]

    def command(self, label: str) -> None:
        self.agent.command(Term(label))

    def crash(self) -> None:
        self.agent.journal.close()  # as the end of the process does
        self._start()
        self.see(0.0)

    @property
    def session(self) -> Any:
        return self.agent.session

    @property
    def active(self) -> str:
        return str(self.session.running.active)

    @property
    def taught(self) -> list[tuple[str, str]]:
        return [(e.state, e.next_state) for e in self.session.examples if not e.is_default]


@contextmanager
def training() -> Iterator[Trained]:
    with tempfile.TemporaryDirectory() as folder:
        yield Trained(Path(folder))


@pytest.fixture
def trained() -> Iterator[Trained]:
    with training() as made:
        yield made


# What must be -----------------------------------------------------------------------------------


def test_after_undo_the_next_command_is_recorded_where_the_undone_one_was(
    trained: Trained,
) -> None:
    """Recorded as leaving the undone state, nothing would leave Start and testing be refused."""
    trained.command("Left")
    trained.session.undo()
    assert trained.active == "Start"
    assert trained.do(1.0) == "start-Left stop-Left", "and nothing is performed any more"
    trained.command("Right")
    assert trained.taught == [("Start", "Right")]
    trained.agent.test()


def test_after_undo_the_body_performs_again_what_it_did_before(trained: Trained) -> None:
    trained.command("Left")
    trained.command("Right")
    trained.do(1.0)
    trained.session.undo()
    assert trained.do(1.0) == "stop-Right start-Left Left"
    assert trained.changes[-1].commanded
    trained.session.redo()
    assert trained.do(1.0) == "stop-Left start-Right Right"


def test_a_command_that_changed_nothing_restarts_nothing_when_undone(trained: Trained) -> None:
    trained.command("Left")
    trained.command("Left")
    trained.do(1.0)
    trained.session.undo()
    assert trained.do(1.0) == "Left"
    trained.session.redo()
    assert trained.do(1.0) == "Left"


def test_undo_after_a_crash_restores_the_state_of_the_command(trained: Trained) -> None:
    trained.command("Left")
    trained.command("Right")
    trained.session.undo()
    trained.crash()
    assert trained.active == "Start", "after a crash nothing moves before a person commands it"
    trained.session.redo()
    assert trained.do(1.0) == "start-Right Right"
    trained.session.undo()
    trained.command("Stay")
    assert trained.taught == [("Start", "Left"), ("Left", "Stay")]


def test_undo_restores_the_state_of_a_takeover(trained: Trained) -> None:
    trained.command("Left")
    trained.see(9.0)
    trained.command("Right")
    trained.agent.test(restart=True)
    trained.do(0.0)
    assert trained.active == "Left"
    trained.agent.take_over()
    trained.command("Stay")
    trained.session.undo()
    assert trained.active == "Left", "that is where testing had brought it"
    trained.session.undo()
    assert trained.active == "Left", "and where the command to go right was given"
    trained.session.undo()
    assert trained.active == "Start"


def test_undo_while_something_else_is_performed_moves_nothing(trained: Trained) -> None:
    trained.command("Left")
    trained.command("Right")
    trained.agent.perform(Term("Stay"))
    trained.do(1.0)
    trained.session.undo()
    assert trained.do(1.0) == "Stay"
    trained.session.redo()
    assert trained.do(1.0) == "Stay"
    trained.agent.take_over()
    assert trained.active == "Start"
    trained.session.undo()
    assert trained.active == "Left"


# Against a plain model --------------------------------------------------------------------------


class Model:
    """What a demonstrator expects, with a copy of everything for each thing that was done."""

    def __init__(self) -> None:
        self.examples: list[list[Any]] = []
        self.active = "Start"
        self.x = 0.0
        self.testing = self.tested = self.away = False
        self.counter = 1
        self.past: list[dict[str, Any]] = []
        self.future: list[dict[str, Any]] = []

    def copy(self) -> list[list[Any]]:
        return [list(e) for e in self.examples]

    def command(self, label: str) -> None:
        source = "Start" if self.active == "Done" else self.active
        before = self.copy()
        kind = "correction" if self.tested else "demonstrated"
        self.examples.append([self.counter, source, self.x, label, kind])
        self.counter += 1
        if label in LASTING and label != source:
            self.examples.append([self.counter, label, self.x, label, "default"])
            self.counter += 1
        self.active = label
        self.mark(self.examples)
        self.past.append({"before": before, "after": self.copy(), "come": source, "go": label})
        self.future.clear()

    def mark(self, examples: list[list[Any]]) -> None:
        """A command outranks default examples with a contrary decision."""
        for e in examples:
            if e[4] in ("default", "superseded"):
                contradicted = any(
                    o[1:3] == e[1:3] and o[3] != e[1]
                    for o in examples
                    if o[4] not in ("default", "superseded")
                )
                e[4] = "superseded" if contradicted else "default"

    def assume(self, examples: list[list[Any]], e: list[Any], label: str) -> list[list[Any]]:
        """The default example of a relabeled command is what another command would have made."""
        default = [o for o in examples if o[0] == e[0] + 1 and o[4] in ("default", "superseded")]
        for o in default:
            if label not in LASTING or label == e[1]:
                return [other for other in examples if other is not o]
            o[1] = o[3] = label
        return examples

    def edit(self, after: list[list[Any]]) -> bool:
        self.mark(after)
        if self.refuses(after):
            return False
        self.past.append({"before": self.copy(), "after": after, "come": None, "go": None})
        self.future.clear()
        self.examples = [list(e) for e in after]
        return True

    def refuses(self, after: list[list[Any]]) -> bool:
        return self.testing and all(e[1] != "Start" for e in after)

    def step(self, here: list[Any], there: list[Any], examples: str, state: str) -> bool:
        if not here or self.refuses(here[-1][examples]):
            return False
        done = here.pop()
        there.append(done)
        self.examples = [list(e) for e in done[examples]]
        if done[state] is not None and not self.away:
            self.active = done[state]
        return True

    def undo(self) -> bool:
        return self.step(self.past, self.future, "before", "come")

    def redo(self) -> bool:
        return self.step(self.future, self.past, "after", "go")

    def come_back(self) -> None:
        if self.away:
            self.away, self.active = False, "Start"


commands = st.tuples(st.just("command"), st.sampled_from(LABELS))
steps = st.lists(
    st.one_of(
        commands,
        commands,
        st.tuples(st.sampled_from(["undo", "redo", "undo", "redo"]), st.none()),
        st.tuples(st.just("tick"), st.sampled_from([0.0, 1.0, 5.0, 9.0])),
        st.tuples(st.sampled_from(["delete", "relabel"]), st.integers(0, 30)),
        st.tuples(st.sampled_from(["test", "train", "restart", "crash", "perform"]), st.none()),
    ),
    max_size=25,
)


def accepted(do: Any, *arguments: Any) -> bool:
    try:
        do(*arguments)
    except TrainingError:
        return False
    return True


def play(trained: Trained, model: Model, what: str, how: Any) -> None:
    """Do the same with an agent and with the model; compare whether it was accepted."""
    session = trained.session
    match what:
        case "command":
            refused = model.testing or model.away
            assert accepted(trained.command, how) == (not refused)
            if not refused:
                model.command(how)
        case "undo" | "redo":
            expected = model.undo() if what == "undo" else model.redo()
            event(f"{what} {expected}")
            assert accepted(session.undo if what == "undo" else session.redo) == expected
        case "delete":
            there = [e[0] for e in model.examples]
            if there:
                number = there[how % len(there)]
                after = [list(e) for e in model.examples if e[0] != number]
                assert accepted(session.delete, [number]) == model.edit(after)
        case "relabel":
            there = [e[0] for e in model.examples]
            if there:
                number, label = there[how % len(there)], LABELS[how % len(LABELS)]
                after = model.copy()
                for e in after:
                    if e[0] == number and e[3] != label:
                        if e[4] not in ("default", "superseded"):
                            after = model.assume(after, e, label)
                        e[3] = label
                        e[4] = "correction" if e[4] in ("default", "superseded") else e[4]
                assert accepted(session.relabel, [number], Term(label)) == model.edit(after)
        case "tick":
            model.x = how
            said = trained.do(how)
            if model.away:
                assert said.split()[-1] == "Stay"
            elif model.testing:
                model.active = trained.active  # what was learned decides
            else:
                if model.active == "Done":
                    model.active = "Start"
                if model.active in LASTING:
                    assert said.split()[-1] == model.active
                assert model.active != "Start" or not said or said.split()[-1][:4] == "stop"
        case "test":
            possible = any(e[1] == "Start" for e in model.examples)
            assert accepted(trained.agent.test) == possible
            if possible:
                model.testing = model.tested = True
                model.come_back()
        case "train":
            trained.agent.take_over()
            model.testing = False
            model.come_back()
        case "restart":
            trained.agent.restart(1, 1)
            model.active = "Start"
        case "perform":
            trained.agent.perform(Term("Stay"))
            model.away, model.active = True, "Start"
        case "crash":
            trained.crash()
            model.x = 0.0
            model.active, model.testing, model.away = "Start", False, False


@settings(max_examples=150)
@given(steps)
def test_whatever_is_done_examples_and_states_are_those_of_a_plain_model(done: list[Any]) -> None:
    with training() as trained:
        model = Model()
        for what, how in done:
            play(trained, model, what, how)
            found = [
                [e.number, e.state, e.features[0], e.next_state, e.kind.value]
                for e in trained.session.examples
            ]
            assert found == model.examples
            assert trained.active == model.active
            log = trained.session.log
            assert (len(log.history.done), len(log.history.undone)) == (
                len(model.past),
                len(model.future),
            )
            defaults = [e[4] for e in model.examples if e[4] in ("default", "superseded")]
            assert [e.kind for e in log.examples if e.is_default] == defaults
            assert (trained.agent.mode is Mode.PERFORMING) == model.away
        trained.agent.journal.close()


def test_relabeling_a_command_takes_its_default_example_along(trained: Trained) -> None:
    """Else it would say to stay in a state to which no command leads any more."""
    session = trained.session

    def shown() -> list[tuple[int, str, str]]:
        return [(e.number, e.state, e.next_state) for e in session.examples]

    for label in ("Left", "Right"):
        trained.command(label)
    both = shown()
    session.relabel([3], Term("Stay"))
    assert shown() == [*both[:2], (3, "Left", "Stay"), (4, "Stay", "Stay")]
    assert session.examples[3].is_default
    assert [str(state) for state in session.states] == ["Left", "Stay"], "no state is left over"
    session.undo()
    for once in ("Beep", "Done"):  # as a command of these, it leaves no default example
        session.relabel([3], Term(once))
        assert shown() == [*both[:2], (3, "Left", once)]
        assert session.log.history.done[-1].endswith("; deleted default example 4")
        session.undo()
    session.relabel([3], Term("Left"))
    assert shown() == [*both[:2], (3, "Left", "Left")], "a command to stay leaves none either"
    session.undo()
    session.relabel([3, 4], Term("Stay"))
    assert shown()[2:] == [(3, "Left", "Stay"), (4, "Right", "Stay")], "both were chosen"


def test_the_history_says_what_undo_and_redo_would_change(trained: Trained) -> None:
    for label in ("Left", "Right", "Beep"):
        trained.command(label)
    trained.session.delete([2])
    trained.session.relabel([1, 3], Term("Stay"))
    trained.session.undo()
    trained.session.undo()
    trained.session.undo()
    log = trained.session.log
    # All were commanded in one situation, where the next command outranks "keep doing this".
    assert log.history.done == [
        "Start → Left, 2 examples",
        "Left → Right, 2 examples; overruled example 2",
    ]
    assert log.history.undone == [
        "Right → Beep, 1 example; overruled example 4",
        "deleted example 2",
        "changed examples 1, 3 to Stay; default example 4 with it",
    ]
    trained.crash()
    log = trained.session.log
    assert (len(log.history.done), len(log.history.undone)) == (2, 3), "the journal keeps it"
    trained.session.redo()
    assert trained.session.log.history.done[-1] == "Right → Beep, 1 example; overruled example 4"
    trained.command("Left")
    assert trained.session.log.history.undone == []


# Cost -------------------------------------------------------------------------------------------


def test_a_command_and_resuming_cost_as_much_per_example_however_many_there_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Comparing each command with all examples, 10,000 took a minute to resume."""
    looks: list[str] = []
    for name in ("is_default", "is_learned", "point"):
        look = getattr(Example, name).fget

        def counted(example: Example, look: Any = look, name: str = name) -> Any:
            looks.append(name)
            return look(example)

        monkeypatch.setattr(Example, name, property(counted))

    def cost(commands: int) -> tuple[int, float, float]:
        with training() as trained:
            for i in range(commands):
                trained.see(float(i))
                trained.command(("Left", "Right")[i % 2])
            looks.clear()
            trained.command(("Left", "Right")[commands % 2])
            trained.session.delete([commands])
            trained.session.relabel([commands - 1], Term("Stay"))
            trained.session.questions.known()
            command = len(looks)
            examples = trained.session.examples
            looks.clear()
            trained.crash()
            resuming = len(looks)
            assert trained.session.examples == examples
            looks.clear()
            assert training_costs(trained.agent.journal)[0].commands == commands + 1
            telling = len(looks)
            trained.agent.journal.close()
            return command, resuming / commands, telling / commands

    few, many = cost(50), cost(100)
    assert few[0] == many[0]
    assert many == pytest.approx(few, rel=0.05)
