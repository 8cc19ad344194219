"""A trainer of one automaton: commands become examples, which become transition functions.

    a command              command(state)
        |
        v
    S_t and f_t            the moment it is meant for: of now, or when it was due (`events`)
        |
        v
    examples               <S_t, f_t, S_t+1>; by default, too: <S_t+1, f_t, S_t+1>
        |
        v
    the journal            on disk before anything is done or acknowledged
        |
        v
    the log                all examples, with undo and redo
        |
        v
    the agent              running.go_to(S_t+1), performed until the next command
        |
        v
    test()                 the examples of each state become its transition function
        |
        v
    take_over()            the demonstrator decides again, from the state that is active

Source: the paper, section 3, "Training with HiTAB".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from hitab_core.automaton import START, Automaton, as_entered
from hitab_core.default_example import default_example
from hitab_core.errors import TrainingError
from hitab_core.example import Example, ExampleKind
from hitab_core.example_codec import example_record
from hitab_core.learning.transition_learning import relearned
from hitab_core.learning.trimming import check_bound, rebind, trim
from hitab_core.running.run_context import RunContext
from hitab_core.running.running_automaton import RunningAutomaton
from hitab_core.term import Term
from hitab_core.training.curriculum import Curriculum, check_curriculum, check_state
from hitab_core.training.events import NOW, CommandGiven, Given, Proposal, TrainingEvents
from hitab_core.training.example_log import ExampleLog, states_in
from hitab_core.training.percept_history import PerceptHistory
from hitab_core.training.percepts import PerceptRecord
from hitab_core.training.undo import Direction, Edit

Record = Mapping[str, Any]
"""A step of a training, as its journal keeps it."""

Journal = Callable[[Record], None]
"""Writes a record to disk before it returns."""


class Trainer:
    """Trains one automaton of one agent.

    In training mode the demonstrator decides: `command` changes the state and records examples. In
    testing mode the learned transition functions decide. Switching between the two keeps the
    active state and its behavior.

    A behavior may take numbers, such as a speed. Then each command gives them, and what was
    learned gives those of the nearest examples.

    Attributes:
        context: of the agent.
        curriculum: what is trained, with the features that were chosen.
        running: the automaton, being performed.
        history: of percepts.
        log: of examples, with what can be undone and redone.
        testing: whether what was learned decides.
        note: what the demonstrator should know of this, until an example is recorded.
        events: that assistants may subscribe to.
    """

    def __init__(
        self,
        context: RunContext,
        curriculum: Curriculum,
        examples: Iterable[Example] = (),
        journal: Journal = lambda record: None,
        names: Sequence[Term] = (),
    ) -> None:
        """Start in training mode, in Start.

        Args:
            context: of the agent.
            curriculum: what to train.
            examples: to continue from, with readings in the order of `PerceptHistory.readable`.
            journal: keeps each step.
            names: of the readings of ``examples``; empty for all that can be read. What cannot be
                read any more is NaN.

        Raises:
            VocabularyError: if the curriculum names what does not exist.
        """
        check_curriculum(curriculum, context.repertoire)
        self.context = context
        self.curriculum = curriculum
        domain = context.repertoire.domain
        self.history = PerceptHistory(domain, curriculum.parameters, curriculum.features, names)
        self.log = ExampleLog(examples)
        self.testing = self._tested = self._taken_over = self._left = False
        self.note, self._journal = "", journal
        self.events = TrainingEvents()
        self.running = self._perform()

    def _perform(self) -> RunningAutomaton:
        """Return the automaton with the states of the examples, in Start."""
        given = self.curriculum
        states = tuple(map(Term.parse, self.states))
        blank = Automaton(given.name, states, given.features, {}, given.parameters)
        bindings = dict(zip(given.parameters, given.arguments, strict=True))
        return RunningAutomaton(self.context, blank, bindings)

    @property
    def examples(self) -> tuple[Example, ...]:
        """The examples recorded so far."""
        return self.log.examples

    @property
    def states(self) -> list[str]:
        """Labels of the states in the examples, in order of appearance, without Start."""
        return states_in(self.log.examples)

    # -- training mode ----------------------------------------------------------------------

    def command(self, state: Term, given: Given = NOW) -> list[Example]:
        """Perform a behavior now and record the resulting examples.

        Args:
            state: the behavior with its targets and numbers, or a flag.
            given: how it is commanded.

        Returns:
            The recorded examples: one, plus a default example unless the behavior is one-shot or
                was already running.

        Raises:
            TrainingError: in testing mode, if the behavior is not among the chosen ones, or if
                the command was due when nothing is known of.
            VocabularyError: if there is no such behavior or target.
            FeatureValueError: if no feature had a value, or one was infinite.
        """
        self._check_in_control()
        state, numbers = self.context.repertoire.commanded(state)
        check_state(state, self.curriculum, self.context.repertoire)
        meant = self._meant(str(state), given)
        taught = self._examples(state, numbers, meant.due)
        record: Record = {"do": "command", "examples": list(map(example_record, taught))}
        record = {**record, **self.history.around(meant.due), **meant.record, **given.record}
        self._do(record, self.log.addition(taught, meant.settled))
        self._go_to(state, numbers, meant.due)
        self.note, self._taken_over = "", False
        return taught

    def _examples(
        self, state: Term, numbers: tuple[float, ...], moment: PerceptRecord
    ) -> list[Example]:
        """Return the example of a command in a moment, and the default example, if it has one."""
        features, log = self.curriculum.features, self.log
        s_t, f_t, s_next = moment.state, self.history.values(moment, features), str(state)
        kind = ExampleKind.CORRECTION if self._tested else ExampleKind.DEMONSTRATED
        ago = max(0.0, self.history.time - moment.time)
        more = log.next_number, log.next_command, moment.cycle, ago, moment.readings, numbers
        example = Example(s_t, f_t, s_next, kind, *more)
        if s_next == s_t or self.context.repertoire.is_one_shot(state):
            return [example]
        return [example, default_example(example, as_entered(features, f_t))]

    def _go_to(self, state: Term, numbers: tuple[float, ...], moment: PerceptRecord) -> None:
        """Begin to perform a commanded state, as if since the moment in which it was due."""
        label, running = str(state), self.running
        self.history.enter(label, moment)
        running.take_down_flags()
        running.add_state(state)
        running.go_to(label)
        running.set_numbers(numbers)
        if label != moment.state:
            running.vector.entered = moment.time

    def _meant(self, label: str, given: Given) -> Proposal:
        """Return the moment for which a command was meant: the present or an earlier one."""
        given.check()
        running, features = self.running, self.curriculum.features
        stated = partial(self.history.due, running, features, given.cycle, given.ago, given.seen)
        taken_over_in = running.active if self._taken_over else ""
        proposal = self.events.commanded(CommandGiven(label, given, taken_over_in, stated))
        return proposal or Proposal(stated())

    def _check_in_control(self) -> None:
        if self.testing:
            raise TrainingError(
                f'"{self.curriculum.name}" is being tested; go to training mode to take over '
                "before commanding"
            )

    # -- testing mode -----------------------------------------------------------------------

    def test(self, *, restart: bool = False) -> None:
        """Learn the transition functions and let them decide.

        Raises:
            TrainingError: if no example leaves Start.
        """
        learned = self.automaton()
        self._do({"do": "test"})
        self.note, self.testing = "", True
        self.running.set_transitions(learned.transitions, learned.numbers)
        self.events.interrupted(self.running.active)
        if restart:
            self.restart()

    def take_over(self) -> None:
        """Give control to the demonstrator, at the active state."""
        self._do({"do": "train"})
        self.events.interrupted(self.running.active)
        self._taken_over, self.testing = self.testing, False

    def automaton(self, done: str = "tested") -> Automaton:
        """Return what has been learned so far, untrimmed.

        Args:
            done: what is to be done with it, for the refusal.

        Raises:
            TrainingError: if no example leaves Start.
        """
        return self._learned(self.log.examples, done)

    def _learned(
        self, examples: tuple[Example, ...], done: str, features: Sequence[str] | None = None
    ) -> Automaton:
        """Return an automaton with a transition function for each state that has examples."""
        given = self.curriculum
        if not any(e.state == START for e in examples):
            first = "take over first, and " if self.testing else ""
            raise TrainingError(
                f'"{given.name}" cannot be {done}: no example leaves {START}; '
                f"{first}command the behavior to begin with"
            )
        states = tuple(map(Term.parse, states_in(examples)))
        chosen = given.features if features is None else tuple(map(Term.parse, features))
        blank = Automaton(given.name, states, chosen, {}, given.parameters, examples)
        domain, readable = self.context.repertoire.domain, self.history.readable
        return relearned(replace(blank, readable=readable), domain, given.classifier)

    # -- the agent perceives and acts -------------------------------------------------------

    def perceive(self, cycle: int, time: float, *, jumped: bool = False) -> None:
        """Keep what the agent perceives now, before it acts on that; see `PerceptHistory.keep`."""
        self.events.perceived(self.history.keep(self.running, cycle, time, jumped=jumped))

    def tick(self) -> None:
        """Perform one timestep.

        Raises:
            FeatureValueError: if a required feature has no value.
        """
        if self.testing:
            self.running.tick()
            self.events.decided(self.running.active)
        else:
            self.running.pulse()

    def restart(self) -> None:
        """Stop the active state and return to Start, as at the beginning of an episode."""
        self.running.stop()
        self.running.start()
        self.note, self._left = "", False
        self.events.episode()
        self.events.begun(self.history.restart(START))

    def leave(self) -> None:
        """Stop, since the agent performs something else; come back with `restart`."""
        self.events.interrupted(self.running.active)
        self.running.stop()
        self._left = True
        self.history.begin()

    # -- undo, redo and what else changes examples --------------------------------------------

    def undo(self) -> None:
        """Undo the last command or edit; undoing a command returns the agent to the state before.

        Raises:
            TrainingError: if there is nothing to undo.
        """
        self.edit({"do": "undo"})

    def redo(self) -> None:
        """Redo what was undone last; for a command, perform the commanded behavior.

        Raises:
            TrainingError: if nothing was undone, or a new edit came after it.
        """
        self.edit({"do": "redo"})

    def edit(self, record: Record) -> None:
        """Change examples as a record of the journal says; in testing mode, learn from them.

        Raises:
            TrainingError: if that is not possible; nothing has changed.
        """
        edit = self.prepared(record)
        assert edit is not None
        learned = None
        if self.testing:  # before the step is made, since learning may be refused
            learned = self._learned(self.log.after(edit), "tested after this", edit.features)
        for label in (*states_in(edit.came), edit.entered or START):  # they may be gone by now
            self.running.add_state(Term.parse(label))
        self._do(record, edit)
        if learned is not None:
            self.running.set_transitions(learned.transitions, learned.numbers)
        if edit.entered is not None and not self._left:
            self._perform_again(edit, edit.entered)

    def _perform_again(self, edit: Edit, entered: str) -> None:
        """Perform the state before an undone command, or the one after a redone command."""
        self.note = ""
        self.running.raised.discard(str(edit.left))
        self.running.go_to(entered)
        numbers = [e.numbers for e in self.examples if e.next_state == entered and e.numbers]
        self.running.set_numbers(numbers[-1] if numbers else ())
        if edit.direction is Direction.UNDO:
            self.history.reenter(str(edit.left), entered)

    def prepared(self, record: Record) -> Edit | None:
        """Return the edit that a record describes, or None if it changes no examples.

        Raises:
            TrainingError: if it is not possible.
        """
        return self.log.prepared(record)

    def _do(self, record: Record, edit: Edit | None = None) -> None:
        """Make a step: on disk first, since what was acknowledged must survive a crash."""
        self._journal({"time": self.history.time, **record})
        self.make(record, edit)

    def make(self, record: Record, edit: Edit | None) -> None:
        """Make a step that is on disk."""
        if edit is not None:
            self.log.make(edit)
        if record["do"] == "command":
            self.history.keep_around(record)
        self._tested |= record["do"] == "test"
        self.events.changed(record)

    # -- saving -----------------------------------------------------------------------------

    def trimmed(
        self, name: str = "", bindings: Mapping[str, str] | None = None, *, keep_unused: bool
    ) -> tuple[Automaton, list[str]]:
        """Return what to save: bound, and without unused states and features; see `Agent.save`.

        Returns:
            The automaton, and notes on what was trimmed.

        Raises:
            TrainingError: if no example leaves Start.
            VocabularyError: if something would remain unbound.
        """
        repertoire, classifier = self.context.repertoire, self.curriculum.classifier
        learned = self.automaton("saved")
        name = name or learned.name
        learned = replace(learned, name=name, description=repertoire.description_of(name))
        if bindings:
            learned = rebind(learned, bindings, repertoire, classifier=classifier)
        if keep_unused:
            check_bound(learned, repertoire.domain)
            return learned, []
        return trim(learned, repertoire, classifier=classifier)
