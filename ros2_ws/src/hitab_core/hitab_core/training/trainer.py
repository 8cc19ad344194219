"""A trainer of one automaton: commands become examples, which become transition functions.

    a command              command(state)
        |
        v
    S_t and f_t            of the percept that the command refers to: the present or an earlier
        |                  one, since people react late (`percept_history`, `events`)
        |
        v
    examples               <S_t, f_t, S_t+1>, and the default example <S_t+1, f_t, S_t+1>
        |
        v
    the journal            written to disk before the command is performed or acknowledged
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
from hitab_core.codec import to_dict
from hitab_core.default_example import default_example
from hitab_core.example import Example, ExampleKind
from hitab_core.learning.transition_learning import relearned
from hitab_core.learning.trimming import check_bound, rebind, trim
from hitab_core.running.run_context import RunContext
from hitab_core.running.running_automaton import RunningAutomaton
from hitab_core.term import Term
from hitab_core.texts.errors import TrainingError
from hitab_core.training.curriculum import Curriculum, check_curriculum, check_state
from hitab_core.training.events import NOW, CommandGiven, Given, Proposal, TrainingEvents
from hitab_core.training.example_log import ExampleLog, states_in
from hitab_core.training.percept_history import PerceptHistory
from hitab_core.training.percepts import PerceptRecord
from hitab_core.training.undo import Direction, Edit

Record = Mapping[str, Any]
"""An entry of a training's journal; ``do`` names the step, such as ``"command"`` or ``"undo"``."""

Journal = Callable[[Record], None]
"""Writes a record to disk before it returns."""


class Trainer:
    """Trains one automaton of one agent.

    In training mode the demonstrator decides: `command` changes the state and records examples. In
    testing mode the learned transition functions decide. Changing the mode keeps the active state
    and its behavior.

    A behavior may take numbers, such as a speed. In training mode the commands give them; in
    testing mode they are computed from the nearest examples.

    Attributes:
        context: the agent's repertoire, body and clock.
        curriculum: name, parameters and chosen features of the automaton in training.
        running: the automaton in training, as the agent performs it.
        history: recent percepts of the agent.
        log: the examples, with undo and redo.
        testing: whether the learned transition functions decide.
        note: a message for the demonstrator; cleared by the next recorded command.
        events: events of this training; assistants may subscribe.
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
            context: the agent's repertoire, body and clock.
            curriculum: the automaton to train.
            examples: examples of an earlier training to continue.
            journal: writes each step to disk.
            names: features that the readings of ``examples`` belong to; empty for all readable
                features. A feature that is no longer readable is NaN.

        Raises:
            VocabularyError: if the curriculum names an unknown behavior, feature or target.
        """
        check_curriculum(curriculum, context.repertoire)
        self.context = context
        self.curriculum = curriculum
        domain = context.repertoire.domain
        self.history = PerceptHistory(domain, curriculum.parameters, curriculum.features, names)
        self.log = ExampleLog(examples)
        self.testing = False
        self._tested = False  # at least once: later commands are corrections
        self._taken_over = False  # from testing mode, with no command since
        self._left = False  # the agent performs another behavior
        self.note, self._journal = "", journal
        self.events = TrainingEvents()
        self.events.interrupted.subscribe(self.history.intervened)
        self.running = self._in_start()

    def _in_start(self) -> RunningAutomaton:
        """Return a running automaton in Start: states of the examples, no transition functions."""
        curriculum = self.curriculum
        states = tuple(map(Term.parse, self.states))
        blank = Automaton(curriculum.name, states, curriculum.features, {}, curriculum.parameters)
        bindings = dict(zip(curriculum.parameters, curriculum.arguments, strict=True))
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
            given: who gives the command, and when it was due; for the past, see `training.past`.

        Returns:
            The recorded examples: one, plus a default example unless it is one-shot or was active.

        Raises:
            TrainingError: in testing mode, if the curriculum excludes the behavior, or if the
                percept at which the command was due is not kept.
            VocabularyError: if there is no such behavior or target.
            FeatureValueError: if no feature had a value, or one was infinite.
        """
        self._check_in_control()
        state, numbers = self.context.repertoire.commanded(state)
        check_state(state, self.curriculum, self.context.repertoire)
        proposal = self._due(str(state), given)
        due, around = proposal.due, self.history.around(proposal.due, given)
        examples, stays = self._examples(state, numbers, due, around), "stays" in around
        record: Record = {"do": "command", "examples": list(map(to_dict, examples)), **around}
        edit = self.log.addition(examples, proposal.settled, stays=stays)
        self._do({**record, **proposal.record}, edit)
        self.running.add_state(state)
        if not stays:
            self._go_to(state, numbers, due)
        self.note, self._taken_over = "", False
        return examples

    def _examples(
        self, state: Term, numbers: tuple[float, ...], due: PerceptRecord, around: Record
    ) -> list[Example]:
        """Return the example of a command that was due at a percept, and its default example."""
        f_t = self.history.values(due, self.curriculum.features)
        example = Example(
            state=due.state,
            features=f_t,
            next_state=str(state),
            kind=ExampleKind.CORRECTION if self._tested else ExampleKind.DEMONSTRATED,
            number=self.log.next_number,
            command=self.log.next_command,
            cycle=due.cycle,
            ago=max(0.0, around.get("as_of", self.history.time) - due.time),
            readings=due.readings,
            numbers=numbers,
        )
        if example.next_state == example.state or self.context.repertoire.is_one_shot(state):
            return [example]
        return [example, default_example(example, as_entered(self.curriculum.features, f_t))]

    def _go_to(self, state: Term, numbers: tuple[float, ...], due: PerceptRecord) -> None:
        """Begin to perform a commanded state; its timer counts from when the command was due."""
        label, running = str(state), self.running
        self.history.enter(label, due)
        running.take_down_flags()
        running.go_to(label)
        running.set_numbers(numbers)
        if label != due.state:
            running.vector.entered = due.time

    def _due(self, label: str, given: Given) -> Proposal:
        """Return when a command was due: by an assistant's estimate, or as the person states."""
        given.check()
        stated = partial(self.history.due, self.running, self.curriculum.features, given)
        taken_over_in = self.running.active if self._taken_over else ""
        proposal = self.events.commanded(CommandGiven(label, given, taken_over_in, stated))
        return proposal or Proposal(stated())

    def _check_in_control(self) -> None:
        if self.testing:
            raise TrainingError(
                f'"{self.curriculum.name}" is being tested; take over before commanding'
            )

    # -- testing mode -----------------------------------------------------------------------

    def test(self, *, restart: bool = False) -> None:
        """Switch to testing mode: learn the transition functions, and let them decide.

        Args:
            restart: also return to Start.

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
        """Switch to training mode, in the active state: the demonstrator decides."""
        self._do({"do": "take_over"})
        self.events.interrupted(self.running.active)
        self._taken_over, self.testing = self.testing, False

    def automaton(self, done: str = "tested") -> Automaton:
        """Return the automaton learned so far, untrimmed.

        Args:
            done: past participle for the error text, as in "cannot be tested".

        Raises:
            TrainingError: if no example leaves Start.
        """
        return self._learned(self.log.examples, done)

    def _learned(
        self, examples: tuple[Example, ...], done: str, features: Sequence[str] | None = None
    ) -> Automaton:
        """Return an automaton with a transition function for each state that has examples."""
        curriculum = self.curriculum
        if not any(e.state == START for e in examples):
            first = "take over first, and " if self.testing else ""
            raise TrainingError(
                f'"{curriculum.name}" cannot be {done}: no example leaves {START}; '
                f"{first}command the behavior to begin with"
            )
        states = tuple(map(Term.parse, states_in(examples)))
        chosen = curriculum.features if features is None else tuple(map(Term.parse, features))
        blank = Automaton(curriculum.name, states, chosen, {}, curriculum.parameters, examples)
        domain, readable = self.context.repertoire.domain, self.history.readable
        return relearned(replace(blank, readable=readable), domain, curriculum.classifier)

    # -- the agent perceives and acts -------------------------------------------------------

    def perceive(self, cycle: int, time: float, *, jumped: bool = False) -> None:
        """Keep the present percept, before the agent acts on it; see `PerceptHistory.keep`."""
        self.events.perceived(self.history.keep(self.running, cycle, time, jumped=jumped))

    def tick(self) -> None:
        """Perform one timestep; only in testing mode may it change the state.

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
        """Stop, since the agent performs another behavior; `restart` resumes the training."""
        self.events.interrupted(self.running.active)
        self.running.stop()
        self._left = True
        self.history.begin()

    # -- undo, redo and other edits of examples -----------------------------------------------

    def undo(self) -> None:
        """Undo the last command or edit; for a command, return to the state before.

        Raises:
            TrainingError: if there is nothing to undo.
        """
        self.edit({"do": "undo"})

    def redo(self) -> None:
        """Redo the last undone command or edit; for a command, perform the behavior again.

        Raises:
            TrainingError: if nothing was undone, or a new edit came after it.
        """
        self.edit({"do": "redo"})

    def edit(self, record: Record) -> None:
        """Carry out an edit of examples; in testing mode, learn from the changed examples.

        Args:
            record: the edit, as the journal keeps it.

        Raises:
            TrainingError: if the edit is impossible; nothing has changed.
        """
        edit = self.prepared(record)
        assert edit is not None
        learned = None
        if self.testing:  # before the step is recorded, since learning may be refused
            learned = self._learned(self.log.after(edit), "tested after this", edit.features)
        # Before it, too: restored examples may use a behavior that the library no longer has.
        for label in (*states_in(edit.came), edit.entered or START):
            self.running.add_state(Term.parse(label))
        self._do(record, edit)
        if learned is not None:
            self.running.set_transitions(learned.transitions, learned.numbers)
        if edit.entered is not None and not self._left:
            self._return_to(edit.entered, edit)

    def _return_to(self, entered: str, edit: Edit) -> None:
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
            TrainingError: if the edit is impossible.
        """
        return self.log.prepared(record)

    def _do(self, record: Record, edit: Edit | None = None) -> None:
        """Write a step to the journal, then make it: acknowledged steps must survive a crash."""
        self._journal({"time": self.history.time, **record})
        self.make(record, edit)

    def make(self, record: Record, edit: Edit | None) -> None:
        """Make a step that the journal has: change the examples and notify assistants."""
        if edit is not None:
            self.log.make(edit)
        self.history.keep_around(record)
        self._tested |= record["do"] == "test"
        self.events.changed(record)

    # -- saving -----------------------------------------------------------------------------

    def trimmed(
        self, name: str = "", bindings: Mapping[str, str] | None = None, *, keep_unused: bool
    ) -> tuple[Automaton, list[str]]:
        """Return the automaton to save, without unused states and features.

        Args:
            name: name to save it under; by default that of the curriculum.
            bindings: a target or parameter for each argument to replace.
            keep_unused: keep unused states and features.

        Returns:
            The automaton, and notes on the trimmed states and features.

        Raises:
            TrainingError: if no example leaves Start.
            VocabularyError: if an argument would remain unbound.
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
