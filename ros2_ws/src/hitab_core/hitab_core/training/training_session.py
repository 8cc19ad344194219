"""Trains one automaton: a demonstrator commands, examples are recorded, functions learned.

Source: the paper, section 3, "Training with HiTAB".
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from hitab_core.advice.remarks import Remark, loops
from hitab_core.automaton import FLAGS, START, Automaton, as_entered
from hitab_core.default_example import default_example
from hitab_core.errors import (
    FeatureValueError,
    HitabError,
    LibraryError,
    TrainingError,
    VocabularyError,
)
from hitab_core.example import Example, ExampleKind
from hitab_core.example_codec import example_record
from hitab_core.learning.transition_learning import relearned
from hitab_core.remedies import Fix
from hitab_core.repertoire import Repertoire
from hitab_core.running.run_context import RunContext
from hitab_core.running.running_automaton import RunningAutomaton
from hitab_core.training.curriculum import Curriculum, check_curriculum
from hitab_core.training.example_log import ExampleLog
from hitab_core.training.exchange import exchange
from hitab_core.training.late_commands import LateCommands
from hitab_core.training.lateness import Lateness
from hitab_core.training.percept_history import PerceptHistory
from hitab_core.training.question import Question, QuestionContext, choice_of
from hitab_core.training.questions import Questions
from hitab_core.training.retiming import retiming
from hitab_core.training.trial_statistics import TrialStatistics
from hitab_core.training.undo import Direction, Edit
from hitab_core.use import Use
from hitab_core.vocabulary import has
from hitab_core.wording import some

Journal = Callable[[Mapping[str, Any]], None]
"""Writes a record to disk before it returns."""


COMMANDS_MAX = 1000
"""Maximum number of commands that are recognized when they come again."""


PACE_MAX = 1000.0
"""No person watches a world that is faster."""


class Request(NamedTuple):
    """A numbered command or edit, which may come again if its acknowledgement was lost."""

    demonstrator: str
    number: int

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Request:
        """Return that which a record of the journal carries out."""
        demonstrator, number = record["request"]
        return cls(str(demonstrator), int(number))


def _forget(record: Mapping[str, Any]) -> None:
    """Keep no journal."""


class TrainingSession:
    """One automaton being trained by one agent.

    In training mode the demonstrator decides: `command` changes the state and records examples. In
    testing mode the learned transition functions decide. Switching between the two keeps the
    active state and its behavior.

    A command can state that it was due earlier; it is then recorded with the situation and the
    active state of that time (`hitab_core.training.recent_percepts`). Each example keeps all
    readings of its situation, so that features can be exchanged afterwards.

    Undoing a command returns the agent to the state before it, so that the next command is
    recorded in that state; redoing it performs the commanded behavior. After a crash the agent is
    in Start, and everything in the journal can still be undone.

    While a required feature has no value, only what stands still is performed; the agent is
    otherwise in Start, and stays there until the next command.

    Attributes:
        asked: what the agent asks the demonstrator.
        note: what the demonstrator should know of this, until an example is recorded.
        perception: what the agent perceived lately, and around each command.
        requests: the latest commands it has obeyed that were numbered, before a crash too.
        edits: that were numbered, made before a crash.
    """

    def __init__(
        self,
        context: RunContext,
        curriculum: Curriculum,
        examples: Iterable[Example] = (),
        journal: Journal = _forget,
        names: Sequence[Use] = (),
        people: dict[str, Lateness] | None = None,
    ) -> None:
        """Start in training mode, in Start.

        Args:
            context: of the agent.
            curriculum: what to train.
            examples: to continue from, with readings in the order of `PerceptHistory.readable`.
            journal: keeps each step.
            names: of the readings of ``examples``; empty for all that can be read. What cannot be
                read any more is NaN.
            people: how late the commands of each demonstrator come; kept up to date.

        Raises:
            VocabularyError: if the curriculum names what does not exist.
        """
        check_curriculum(curriculum, context.repertoire)
        self.context = context
        self.curriculum = curriculum
        domain = context.repertoire.domain
        self.perception = PerceptHistory(domain, curriculum.parameters, curriculum.features, names)
        self.log = ExampleLog(examples)
        self.testing = False
        self.questions = Questions(self.log, self.perception.situations, self._material)
        self.requests: deque[Request] = deque(maxlen=COMMANDS_MAX)
        self.edits: deque[Request] = deque(maxlen=COMMANDS_MAX)
        self._asked_by: Request | None = None
        self.note = ""
        self.late = LateCommands({} if people is None else people)
        self._loops: tuple[tuple[Example, ...], list[Remark]] = (), []
        self._trial = TrialStatistics()
        self._taken_over = False
        self._tested = False
        self._left = False
        self._journal = journal
        self.running = self._perform(())

    def _perform(self, states: Sequence[Use]) -> RunningAutomaton:
        blank = Automaton(
            self.curriculum.name,
            tuple(states),
            self.curriculum.features,
            {},
            self.curriculum.parameters,
        )
        running = RunningAutomaton(self.context, blank, self._bindings)
        for label in _labels(self.log.examples):
            running.add_state(Use.parse(label))
        return running

    @property
    def _bindings(self) -> dict[str, str]:
        return dict(zip(self.curriculum.parameters, self.curriculum.arguments, strict=True))

    @property
    def examples(self) -> tuple[Example, ...]:
        """The examples recorded so far."""
        return self.log.examples

    @property
    def states(self) -> list[str]:
        """Labels of the states in the examples, in order of appearance, without Start."""
        return _labels(self.log.examples)

    def tick(self) -> None:
        """Perform one timestep.

        Raises:
            FeatureValueError: if a required feature has no value.
        """
        if self.testing:
            self.running.tick()
            self._trial.see(self.running.active, self.log.examples)
            return
        try:
            if not self.context.repertoire.stands_still(Use.parse(self.running.active)):
                self.running.vector.check_required()
            self.running.pulse()
        except Exception as error:
            if self.running.active != START:
                self.note = f"stands still until the next command: {error}"
            self.running.stop()
            self._taken_over = False
            raise

    def restart(self) -> None:
        """Stop the active state and return to Start, as at the beginning of an episode."""
        self.running.stop()
        self.running.start()
        self._trial.begin(whole=self.testing)
        self.note = ""
        self._left = False
        self.perception.restart()

    def leave(self) -> None:
        """Stop, since the agent performs something else; come back with `restart`."""
        self._trial.interrupt(self.running.active)
        self.running.stop()
        self._left = True
        self.perception.begin()

    def check_on(self, repertoire: Repertoire) -> None:
        """Check that the training could continue with another repertoire.

        Raises:
            VocabularyError: naming what is missing there.
        """
        check_curriculum(self.curriculum, repertoire)
        for label in _labels(self.log.examples):
            repertoire.check_state(Use.parse(label), self.curriculum.parameters)

    def replay(self, records: Iterable[Mapping[str, Any]]) -> None:
        """Replay the journal of the training, without its first record.

        Raises:
            VocabularyError: if an example uses a behavior that no longer exists.
        """
        for record in records:
            edit = self._prepared(record)
            if edit is not None:
                self._make(edit)
            if record["do"] == "command":
                self._keep(record)
            elif "request" in record:
                self.edits.append(Request.from_record(record))
            if record["do"] == "dismiss":
                self.questions.dismiss(record["key"])
            self._tested |= record["do"] == "test"
        self.perception.remember()
        self.check_on(self.context.repertoire)
        self.rebuild(self.context)

    def _keep(self, record: Mapping[str, Any]) -> None:
        """Keep what the record of a command tells besides its examples."""
        self.perception.keep_around(int(record["examples"][0]["command"]), record)
        self.late.keep(record)
        if "request" in record:
            self.requests.append(Request.from_record(record))

    def rebuild(self, context: RunContext) -> None:
        """Restart at Start, since behaviors of the repertoire may have changed."""
        self.context = context
        self.running = self._perform(())
        if self.testing:
            automaton = self.automaton()
            self.running.set_transitions(automaton.transitions, automaton.numbers)

    def command(
        self,
        state: Use,
        cycle: int = 0,
        *,
        ago: float = 0.0,
        seen: int = 0,
        pace: float = 0.0,
        request: Request | None = None,
    ) -> list[Example]:
        """Perform a behavior now and record the resulting examples.

        Args:
            state: the behavior with its targets and numbers, or a flag.
            cycle: of the world, stored with the examples.
            ago: how long before what the demonstrator saw the command was due, s of simulated
                time. The examples are of that moment, and leave the state that was active then.
            seen: the world's cycle that the demonstrator saw; 0 for the last one.
            pace: simulated seconds that pass for the demonstrator in a second; 0 if the situation
                has waited. Without ``ago``, how late the command comes is then estimated
                (`hitab_core.training.lateness`), and that of earlier ones again.
            request: who commands it and with which number, to recognize it when it comes again.

        Returns:
            The recorded examples: one, plus a default example unless the behavior is one-shot or
                was already running. None of one that stands still if it cannot be recorded; the
                note says why.

        Raises:
            TrainingError: in testing mode, if the behavior is not among the chosen ones, or if
                the command was due when nothing is known of.
            VocabularyError: if there is no such behavior or target.
            FeatureValueError: if no feature had a value, or one was infinite.
        """
        self._check_controlled()
        state, numbers = self.context.repertoire.commanded(state)
        try:
            taught = self._record(state, numbers, cycle, ago, seen, pace, request)
            self.note = ""
        except (FeatureValueError, TrainingError, LibraryError) as error:
            if not self.context.repertoire.stands_still(state):
                raise
            taught = self._enter(state, f"stands still, but {state} was not recorded: {error}")
        self._taken_over = False
        return taught

    def bring_into(self, state: Use) -> list[Example]:
        """Perform a behavior now and record nothing, such as to correct what is done there.

        Raises:
            TrainingError, VocabularyError: as `command`.
        """
        self._check_controlled()
        state, numbers = self.context.repertoire.commanded(state)
        self._check_state(state)
        self._enter(state, f"was brought into {state}; no example was recorded")
        self.running.set_numbers(numbers)
        self._taken_over = False
        return []

    def _enter(self, state: Use, note: str) -> list[Example]:
        """Perform a behavior of which no example is recorded."""
        self.note = note
        self.running.take_down_flags()
        self.running.add_state(state)
        self.running.go_to(str(state))
        self.perception.restart(str(state))
        return []

    def _check_controlled(self) -> None:
        if self.testing:
            raise TrainingError(
                f'"{self.curriculum.name}" is being tested; go to training mode to take over '
                "before commanding"
            )

    def _record(
        self,
        state: Use,
        numbers: tuple[float, ...],
        cycle: int,
        ago: float,
        seen: int,
        pace: float,
        request: Request | None,
    ) -> list[Example]:
        self._check_state(state)
        label = str(state)
        perception, chosen, running = self.perception, self.curriculum.features, self.running
        who = request.demonstrator if request is not None else ""
        if not 0.0 <= pace <= PACE_MAX:
            raise TrainingError(
                f"the pace of the world cannot be {pace:g} simulated seconds in a second; give a "
                f"number from 0 (it waits) to {PACE_MAX:g}"
            )
        if ago or not perception.is_past:
            pace = 0.0  # it is known how late the command is
        if pace:
            due = perception.moments.due(self.late.usual(who, pace), seen)
        else:
            due = perception.due(running, chosen, cycle, ago, seen)
        around = perception.around(due, running.active if self._taken_over else "", label, pace)
        settled: list[Example] = []
        if pace:
            scales = list(map(self.context.repertoire.domain.scale_of, chosen))
            due, settled = self.late.settle(
                perception, self.log, chosen, scales, label=label, around=around, who=who, due=due
            )
        again = label == due.state
        values = perception.values(due, chosen)
        kind = ExampleKind.CORRECTION if self._tested else ExampleKind.DEMONSTRATED
        ago = max(0.0, perception.time - due.time)
        number, command = self.log.next_number, self.log.next_command
        found = (kind, number, command, due.cycle, ago, due.readings, numbers)
        taught = [Example(due.state, values, label, *found)]
        if not again and not self.context.repertoire.is_one_shot(state):
            taught.append(default_example(taught[0], as_entered(chosen, values)))
        edit = self.log.addition(taught, settled)
        # On disk first: acknowledged examples must survive a crash.
        record = {"do": "command", "examples": [example_record(e) for e in taught], **around}
        if pace:
            record |= {"settled": [example_record(e) for e in settled], "who": who}
        if request is not None:
            record["request"] = list(request)
        self._write(record)
        self.log.make(edit)
        self._keep(record)
        perception.enter(label, due)
        running.take_down_flags()
        running.add_state(state)
        running.go_to(label)
        running.set_numbers(numbers)
        if not again:
            running.vector.entered = due.time
        return taught

    def _write(self, record: Mapping[str, Any]) -> None:
        """Write a step to the journal, with its time; it is on disk when this returns."""
        self._journal({"time": self.perception.time, **record})

    def test(self, *, restart: bool = False) -> None:
        """Learn the transition functions and let them decide.

        Raises:
            TrainingError: if no example leaves Start.
        """
        automaton = self.automaton()
        self._write({"do": "test"})
        self.note = ""
        self.running.set_transitions(automaton.transitions, automaton.numbers)
        self.testing = self._tested = True
        self._trial.interrupt(self.running.active)
        if restart:
            self.restart()

    def take_over(self) -> None:
        """Give control to the demonstrator, at the active state."""
        self._write({"do": "train"})
        self._trial.interrupt(self.running.active)
        self._taken_over = self.testing
        self.testing = False

    def search(self) -> Iterator[None]:
        """Look for questions in steps, see `Questions.search`, and for loops."""
        yield from self.questions.search()
        self.remarks(look=True)

    def remarks(self, *, look: bool = False) -> list[Remark]:
        """Return signs that what was learned does not play.

        Args:
            look: for loops, too, if the examples have changed since this was done.
        """
        examples = self.log.examples
        if look and self._loops[0] is not examples:
            found: list[Remark] = []
            with suppress(HitabError):  # testing says what cannot be learned from
                classifier = self.curriculum.classifier
                found = loops(self.automaton(), self.context.repertoire, classifier)
            self._loops = examples, found
        about, found = self._loops
        return [*(found if about is examples else ()), *self._trial.remarks(examples)]

    def _material(self) -> QuestionContext:
        examples, features = self.log.examples, self.curriculum.features
        met = self.perception.situations
        repertoire = self.context.repertoire
        return QuestionContext(
            examples,
            tuple(repertoire.domain.scale_of(use) for use in features),
            tuple(map(str, features)),
            tuple(repertoire.domain.feature(use.name).unit for use in features),
            self.curriculum.classifier,
            tuple(self.states),
            tuple(map(str, self.curriculum.states)) or tuple(self.states),
            tuple((m.state, self.perception.in_moment(m, features)) for m in met),
        )

    def answer(self, number: int, choice: str = "", *, dismiss: bool = False) -> Question:
        """Answer a question; undo takes the answer back.

        Args:
            number: of the question.
            choice: the name of one of its choices; empty for the proposed one.
            dismiss: change nothing, and do not ask this again.

        Raises:
            TrainingError: if the question is not open, or has no such choice.
        """
        question = self.questions.get(number)
        chosen = choice_of(question, choice)
        if dismiss or chosen.record is None:
            self._write({"do": "dismiss", "key": list(question.words)})
            self.questions.dismiss(question.words)
            return question
        self._edit({**chosen.record, "proposed": chosen is question.choices[0]})
        self.questions.answered.append(f"{question.text} {chosen.name}")
        return question

    def begins(self, request: Request) -> bool:
        """Note whose edit comes next; return False if it was made already, before a crash too."""
        self._asked_by = request if request.number else None
        return request not in self.edits

    def undo(self) -> None:
        """Undo the last command, deletion or relabeling.

        Undoing a command returns the agent to the state before it.

        Raises:
            TrainingError: if there is nothing to undo.
        """
        self._edit({"do": "undo"})

    def redo(self) -> None:
        """Redo what was undone last; for a command, perform the commanded behavior.

        Raises:
            TrainingError: if nothing was undone, or a new edit came after it.
        """
        self._edit({"do": "redo"})

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete examples by number.

        Raises:
            TrainingError: if one of the numbers is unknown.
        """
        self._edit({"do": "delete", "numbers": sorted(set(numbers))})

    def relabel(self, numbers: Iterable[int], next_state: Use) -> None:
        """Change the next state of examples, and of what their commands recorded by default.

        Raises:
            TrainingError: if one of the numbers is unknown.
            VocabularyError: if there is no such behavior, or a number of its own is wrong.
        """
        self._check_state(next_state)
        state, given = self.context.repertoire.commanded(next_state)
        record = {"do": "relabel", "numbers": sorted(set(numbers)), "next_state": str(state)}
        goes_on = not self.context.repertoire.is_one_shot(state)
        self._edit({**record, "goes_on": goes_on, **({"with": list(given)} if given else {})})

    def retime(self, numbers: Iterable[int], ago: float) -> None:
        """Have commands been due at another time.

        All examples of a command get the situation of that time; the first of them leaves the
        state that was active then.

        Args:
            numbers: of examples; each stands for its command.
            ago: how long before the command it was due, s of simulated time.

        Raises:
            TrainingError: if one of the numbers is unknown, or that time is not kept.
            FeatureValueError: if no feature had a value then, or one was infinite.
        """
        self._edit({"do": "retime", "numbers": sorted(set(numbers)), "ago": ago})

    def choose_features(self, features: Sequence[Use]) -> None:
        """Learn from other features of the same examples.

        Raises:
            TrainingError: if a feature has no value in any example.
            VocabularyError: if there is no such feature.
        """
        self._check_features(features)
        self._edit({"do": "features", "features": [str(use) for use in features]})

    def with_features(self, features: Sequence[Use]) -> Automaton:
        """Return what would be learned from other features of the same examples, untrimmed.

        Raises:
            TrainingError: if a feature has no value in any example, or no example leaves Start.
            VocabularyError: if there is no such feature.
        """
        self._check_features(features)
        edit = exchange(self.log, self.curriculum, features, self.perception.readable)
        return self._learned(self.log.after(edit), "shown", edit.features)

    def _prepared(self, record: Mapping[str, Any]) -> Edit | None:
        """Return the edit that a record describes, or None if it describes none.

        Raises:
            TrainingError: if it is not possible.
        """
        match record["do"]:
            case "retime":
                numbers, ago = record["numbers"], float(record["ago"])
                return retiming(self.log, self.perception, numbers, ago, self.curriculum.features)
            case "features":
                features = tuple(map(Use.parse, record["features"]))
                return exchange(self.log, self.curriculum, features, self.perception.readable)
        return self.log.prepared(record)

    def _check_features(self, features: Sequence[Use]) -> None:
        chosen = replace(self.curriculum, features=tuple(features))
        check_curriculum(chosen, self.context.repertoire)
        unread = [use for use in features if use not in self.perception.readable]
        if unread and not self.log.examples:
            raise TrainingError(
                f"{some([str(use) for use in unread])} cannot be chosen any more: of a domain "
                "with so many features, a training reads some only if they are chosen when it "
                "begins",
                Fix.TRAIN(behavior=self.curriculum.name, feature=unread[0]),
            )

    def _make(self, edit: Edit) -> None:
        """Make a prepared edit."""
        self.log.make(edit)
        if edit.features is not None:
            features = tuple(map(Use.parse, edit.features))
            self.curriculum = replace(self.curriculum, features=features)

    def _edit(self, record: Mapping[str, Any]) -> None:
        asked_by, self._asked_by = self._asked_by, None
        # Refuse before writing anything.
        edit = self._prepared(record)
        assert edit is not None
        learned = None
        if self.testing:
            learned = self._learned(self.log.after(edit), "tested after this", edit.features)
        labels = _labels(edit.came)
        if edit.entered not in (None, START):
            labels.append(str(edit.entered))
        for label in labels:
            self.running.add_state(Use.parse(label))
        if asked_by is not None:
            record = {**record, "request": list(asked_by)}
        self._write(record)
        self._make(edit)
        if edit.features is not None:
            self.running.set_features(self.curriculum.features)
        if learned is not None:
            self.running.set_transitions(learned.transitions, learned.numbers)
        self._perform_again(edit)

    def _perform_again(self, edit: Edit) -> None:
        """Perform the state before an undone command, or the one after a redone command."""
        if edit.entered is None or self._left:
            return
        self.note = ""
        self.running.raised.discard(str(edit.left))
        self.running.go_to(edit.entered)
        numbers = [e.numbers for e in self.examples if e.next_state == edit.entered and e.numbers]
        self.running.set_numbers(numbers[-1] if numbers else ())
        if edit.direction is Direction.UNDO:
            self.perception.reenter(str(edit.left), edit.entered)

    def automaton(self, done: str = "tested") -> Automaton:
        """Return what has been learned so far, untrimmed.

        Args:
            done: what is to be done with it, for the refusal.

        Raises:
            TrainingError: if no example leaves Start.
        """
        return self._learned(self.log.examples, done)

    def _learned(
        self,
        examples: tuple[Example, ...],
        done: str = "tested",
        features: Sequence[str] | None = None,
    ) -> Automaton:
        if not any(e.state == START for e in examples):
            first = "take over first, and " if self.testing else ""
            raise TrainingError(
                f'"{self.curriculum.name}" cannot be {done}: no example leaves {START}; '
                f"{first}command the behavior to begin with"
            )
        chosen = self.curriculum.features if features is None else map(Use.parse, features)
        unlearned = Automaton(
            self.curriculum.name,
            tuple(Use.parse(label) for label in _labels(examples)),
            tuple(chosen),
            {},
            self.curriculum.parameters,
            examples,
            readable=self.perception.readable,
        )
        return relearned(unlearned, self.context.repertoire.domain, self.curriculum.classifier)

    def _check_state(self, state: Use) -> None:
        if state.name == self.curriculum.name:
            raise VocabularyError(
                f'recursive automaton: "{state.name}" is what is being trained; '
                "a behavior cannot use itself"
            )
        self.context.repertoire.check_state(state, self.curriculum.parameters)
        needed = self.context.repertoire
        if state.name not in FLAGS and self.curriculum.name in needed.needed_by(state.name):
            raise VocabularyError(
                f'recursive automaton: "{state.name}" uses "{self.curriculum.name}", '
                "which is being trained"
            )
        chosen = self.curriculum.states
        if chosen and state not in chosen:
            raise TrainingError(
                f'"{state}" is not among the states chosen for "{self.curriculum.name}" '
                f"{has(chosen, state)}; begin again with this state, or without a choice of states"
            )


def _labels(examples: Iterable[Example]) -> list[str]:
    """Return the states in the examples, in order of appearance, without Start."""
    seen: dict[str, None] = {}
    for example in examples:
        for label in (example.state, example.next_state):
            if label != START:
                seen.setdefault(label)
    return list(seen)
