"""Trains one automaton: a demonstrator commands, examples are recorded, functions learned.

Source: the paper, section 3, "Training with HiTAB".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.errors import FeatureValueError, TrainingError, VocabularyError
from hitab_core.example import Example, ExampleKind
from hitab_core.example_codec import example_record
from hitab_core.learning.transition_learning import learn_transitions, learner
from hitab_core.running.running_automaton import RunContext, RunningAutomaton
from hitab_core.training.example_log import Edit, ExampleLog
from hitab_core.training.training_record import prepared, replay
from hitab_core.use import NAME, NAME_RULE, Use
from hitab_core.vocabulary import check_known, has

Journal = Callable[[Mapping[str, Any]], None]
"""Writes a record to disk before it returns."""


def _forget(record: Mapping[str, Any]) -> None:
    """Keep no journal."""


@dataclass(frozen=True)
class Curriculum:
    """The choices made before training begins.

    Attributes:
        name: of the automaton to be trained.
        features: what its transition functions may look at.
        states: that may be commanded; empty: anything in the repertoire.
        parameters: its free variables.
        arguments: the targets that the parameters are bound to during training.
        classifier: ``"tree"`` or a scikit-learn classifier (`classifier_replacement`).
    """

    name: str
    features: tuple[Use, ...]
    states: tuple[Use, ...] = ()
    parameters: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()
    classifier: str = "tree"

    def to_record(self) -> dict[str, Any]:
        """Return it as plain data for the journal."""
        return {
            "automaton": self.name,
            "features": [str(f) for f in self.features],
            "states": [str(s) for s in self.states],
            "parameters": list(self.parameters),
            "arguments": list(self.arguments),
            "classifier": self.classifier,
        }

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Curriculum:
        """Read what `to_record` wrote."""
        return cls.parse(
            record["automaton"],
            record["features"],
            record["states"],
            record["parameters"],
            record["arguments"],
            record["classifier"],
        )

    @classmethod
    def parse(
        cls,
        name: str,
        features: Iterable[str],
        states: Iterable[str],
        parameters: Iterable[str],
        arguments: Iterable[str],
        classifier: str,
    ) -> Curriculum:
        """Return a curriculum whose features and states are given as texts.

        Raises:
            VocabularyError: if a text is not a use of a behavior or feature.

        Example:
            >>> wanted = Curriculum.parse("GoTo", ["DistanceTo(A)"], [], ["A"], ["ball"], "tree")
            >>> wanted.features
            (Use(name='DistanceTo', arguments=('A',)),)
        """
        return cls(
            name,
            tuple(map(Use.parse, features)),
            tuple(map(Use.parse, states)),
            tuple(parameters),
            tuple(arguments),
            classifier,
        )


class TrainingSession:
    """One automaton being trained by one agent.

    In training mode the demonstrator decides: `command` changes the state and records examples. In
    testing mode the learned transition functions decide. Switching between the two keeps the
    active state and what it performs.

    Undoing a command returns the agent to the state before it, so that the next command is
    recorded in that state; redoing it performs the commanded behavior. After a crash the agent is
    in Start, and everything in the journal can still be undone.
    """

    def __init__(
        self,
        context: RunContext,
        curriculum: Curriculum,
        examples: Iterable[Example] = (),
        journal: Journal = _forget,
    ) -> None:
        """Start in training mode, in Start.

        Raises:
            VocabularyError: if the curriculum names what does not exist.
        """
        check(context, curriculum)
        self.context = context
        self.curriculum = curriculum
        self.log = ExampleLog(examples)
        self.testing = False
        self._tested = False
        self._left = False
        self._journal = journal
        self.running = self._perform(())

    def _perform(self, states: Sequence[Use]) -> RunningAutomaton:
        bindings = dict(zip(self.curriculum.parameters, self.curriculum.arguments, strict=True))
        blank = Automaton(
            self.curriculum.name,
            tuple(states),
            self.curriculum.features,
            {},
            self.curriculum.parameters,
        )
        running = RunningAutomaton(self.context, blank, bindings)
        for label in _labels(self.log.examples):
            running.add_state(Use.parse(label))
        return running

    @property
    def examples(self) -> tuple[Example, ...]:
        """The examples recorded so far."""
        return self.log.examples

    @property
    def states(self) -> list[str]:
        """Labels of the states in the examples, in order of appearance, without Start."""
        return _labels(self.log.examples)

    def tick(self) -> None:
        """Perform one timestep."""
        if self.testing:
            self.running.tick()
        else:
            self.running.pulse()

    def restart(self) -> None:
        """Stop the active state and return to Start, as at the beginning of an episode."""
        self.running.stop()
        self.running.start()
        self._left = False

    def leave(self) -> None:
        """Stop, since the agent performs something else; come back with `restart`."""
        self.running.stop()
        self._left = True

    def check_on(self, context: RunContext) -> None:
        """Check that the training could continue with another repertoire.

        Raises:
            VocabularyError: naming what is missing there.
        """
        check(context, self.curriculum)
        for label in _labels(self.log.examples):
            context.repertoire.check_state(Use.parse(label), self.curriculum.parameters)

    def replay(self, records: Iterable[Mapping[str, Any]]) -> None:
        """Replay the journal of the training.

        Raises:
            VocabularyError: if an example uses a behavior that no longer exists.
        """
        records = list(records)
        replay(records, self.log)
        self._tested = any(record["do"] == "test" for record in records)
        self.check_on(self.context)
        self.rebuild(self.context)

    def rebuild(self, context: RunContext) -> None:
        """Restart at Start, since behaviors of the repertoire may have changed."""
        self.context = context
        self.running = self._perform(())
        if self.testing:
            self.running.set_transitions(self.automaton().transitions)

    def command(self, state: Use, cycle: int = 0) -> list[Example]:
        """Perform a behavior now and record the resulting examples.

        Args:
            state: the behavior with its arguments, or a flag.
            cycle: of the world, stored with the examples.

        Returns:
            The recorded examples: one, plus a default example unless the behavior is one-shot or
                was already running.

        Raises:
            TrainingError: in testing mode, or if the behavior is not among the chosen ones.
            VocabularyError: if there is no such behavior or target.
            FeatureValueError: if a feature has no value now, or one that is not finite.
        """
        if self.testing:
            raise TrainingError(
                f'"{self.curriculum.name}" is being tested; go to training mode to take over '
                "before commanding"
            )
        self._check_state(state)
        running = self.running
        label = str(state)
        source = START if running.active in FLAGS else running.active
        again = label == source
        features = tuple(running.peek_features())
        self._check_finite(features)
        taught = self.log.preview(
            source,
            features,
            label,
            kind=ExampleKind.CORRECTION if self._tested else ExampleKind.DEMONSTRATED,
            with_default=not again and not self.context.repertoire.is_one_shot(state),
            cycle=cycle,
        )
        # On disk first: acknowledged examples must survive a crash.
        self._journal({"do": "command", "examples": [example_record(e) for e in taught]})
        self.log.make(self.log.addition(taught))
        running.take_down_flags()
        running.add_state(state)
        running.go_to(label)
        return taught

    def _check_finite(self, values: Iterable[float]) -> None:
        for feature, value in zip(self.curriculum.features, values, strict=True):
            if not math.isfinite(value):
                raise FeatureValueError(
                    f'feature "{feature}" is {value} but must be finite in an example; have it '
                    "return a large number instead, such as the range of its sensor"
                )

    def test(self, *, restart: bool = False) -> None:
        """Learn the transition functions and let them decide.

        Raises:
            TrainingError: if no example leaves Start.
        """
        automaton = self.automaton()
        self._journal({"do": "test"})
        self.running.set_transitions(automaton.transitions)
        if restart:
            self.restart()
        self.testing = self._tested = True

    def take_over(self) -> None:
        """Give control to the demonstrator, at the active state."""
        self._journal({"do": "train"})
        self.testing = False

    def undo(self) -> None:
        """Undo the last command, deletion or relabelling.

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
        """Change the next state of examples.

        Raises:
            TrainingError: if one of the numbers is unknown.
            VocabularyError: if there is no such behavior.
        """
        self._check_state(next_state)
        self._edit(
            {"do": "relabel", "numbers": sorted(set(numbers)), "next_state": str(next_state)}
        )

    def _edit(self, record: Mapping[str, Any]) -> None:
        # Refuse before writing anything.
        edit = prepared(self.log, record)
        assert edit is not None
        learned = self._learned(self.log.after(edit)) if self.testing else None
        labels = _labels(example for _, example in edit.came)
        if edit.entered not in (None, START):
            labels.append(str(edit.entered))
        for label in labels:
            self.running.add_state(Use.parse(label))
        self._journal(record)
        self.log.make(edit)
        if learned is not None:
            self.running.set_transitions(learned.transitions)
        self._perform_again(edit)

    def _perform_again(self, edit: Edit) -> None:
        """Perform the state before an undone command, or the one after a redone command."""
        if edit.entered is None or self._left:
            return
        self.running.raised.discard(str(edit.left))
        self.running.go_to(edit.entered)

    def automaton(self, done: str = "tested") -> Automaton:
        """Return what has been learned so far, untrimmed.

        Args:
            done: what is to be done with it, for the refusal.

        Raises:
            TrainingError: if no example leaves Start.
        """
        return self._learned(self.log.examples, done)

    def _learned(self, examples: tuple[Example, ...], done: str = "tested") -> Automaton:
        if not any(e.state == START for e in examples):
            raise TrainingError(
                f'"{self.curriculum.name}" cannot be {done}: no example leaves {START}; '
                "command the behavior that it should begin with"
            )
        repertoire = self.context.repertoire
        scales = [repertoire.scale_of(feature) for feature in self.curriculum.features]
        names = [str(feature) for feature in self.curriculum.features]
        return Automaton(
            self.curriculum.name,
            tuple(Use.parse(label) for label in _labels(examples)),
            self.curriculum.features,
            learn_transitions(examples, scales, self.curriculum.classifier, names),
            self.curriculum.parameters,
            examples,
        )

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


def check(context: RunContext, curriculum: Curriculum) -> None:
    """Check that everything a curriculum names exists, including its classifier.

    Raises:
        VocabularyError: naming what does not exist.
    """
    repertoire = context.repertoire
    name = curriculum.name
    for text in (name, *curriculum.parameters):
        if NAME.match(text) is None:
            raise VocabularyError(f'"{text}" is not a name; {NAME_RULE}')
    if len(set(curriculum.parameters)) < len(curriculum.parameters):
        raise VocabularyError(f'"{name}" has a parameter twice; give each a name of its own')
    if len(curriculum.parameters) != len(curriculum.arguments):
        raise VocabularyError(
            f'"{name}" has {len(curriculum.parameters)} parameter(s) but '
            f"{len(curriculum.arguments)} target(s) to train with"
        )
    for argument in curriculum.arguments:
        check_known("target", argument, repertoire.domain.targets)
    if len(set(curriculum.features)) < len(curriculum.features):
        raise VocabularyError(f'"{name}" has a feature twice')
    for feature in curriculum.features:
        repertoire.check_feature(feature, curriculum.parameters)
    for state in curriculum.states:
        repertoire.check_state(state, curriculum.parameters)
    # Check an empty automaton for reserved names and for parameters that are targets.
    blank = Automaton(name, (), curriculum.features, {}, curriculum.parameters)
    repertoire.check_new(blank)
    learner(curriculum.classifier, [repertoire.scale_of(f) for f in curriculum.features])


def _labels(examples: Iterable[Example]) -> list[str]:
    """Return the states in the examples, in order of appearance, without Start."""
    seen: dict[str, None] = {}
    for example in examples:
        for label in (example.state, example.next_state):
            if label != START:
                seen.setdefault(label)
    return list(seen)
