"""Questions of an agent about the examples of its training, and the effects of answers.

There are two kinds of questions: two commands in the same situation contradict each other; or a
situation was met, and nothing like it was shown. Each is found again from the present examples
(`hitab_core.advice`), so an answer that changes them ends its question, and undoing the answer
asks it again.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hitab_core.advice.changed import Changed, changed
from hitab_core.advice.evidence import Evidence
from hitab_core.advice.unshown import Unshown, unshown
from hitab_core.assistant import question_texts
from hitab_core.assistant.question import Choice, Question, QuestionKind, added
from hitab_core.assistant.situation_sample import SituationSample
from hitab_core.automaton import FLAGS, OWN_FEATURES, START
from hitab_core.example import Example, ExampleKind, contradictions
from hitab_core.learning import TREE
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.numeric.arrays import Booleans
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.vocabulary import has
from hitab_core.texts.wording import numbered
from hitab_core.training.percepts import PerceptRecord
from hitab_core.training.trainer import Trainer
from hitab_core.training.undo import Edit

TIMERS = tuple(term for term in OWN_FEATURES if term.name not in FLAGS)
"""Timers are excluded: their reset is not an event in the world."""

CORRECTED = 2
"""Number of other commands that a correction outweighs evenly."""

WITH_EFFECTS_MAX = 3
"""Maximum number of questions for which the effects of answers are computed in advance."""


class _Material:
    """Data from which questions are found.

    Attributes:
        examples: examples of the training.
        classifier: classifier that learns from them.
        labels: labels of the states, without Start.
        goals: labels of possible answers: the chosen states, or else those in the examples.
        met: a sample of the situations met: feature values, each with the state of that time.
    """

    def __init__(self, trainer: Trainer, situations: SituationSample) -> None:
        chosen, domain = trainer.curriculum, trainer.context.repertoire.domain
        features, in_moment = chosen.features, trainer.history.in_moment
        self.examples = trainer.examples
        self.classifier = chosen.classifier
        self.labels = tuple(trainer.states)
        self.goals = tuple(map(str, chosen.states)) or self.labels
        self.met = [(m.state, in_moment(m, features)) for m in situations]
        units = tuple(domain.feature(term.name).unit for term in features)
        scales, names = tuple(map(domain.scale_of, features)), tuple(map(str, features))
        self._about = scales, names, units, chosen.classifier

    def evidence(self, state: str, examples: Sequence[Example] | None = None) -> Evidence:
        """Return the evidence from which the transition function of a state is learned."""
        return Evidence.of(state, self.examples if examples is None else examples, *self._about)


class Questions:
    """The questions of one training, numbered as they come up.

    Args:
        trainer: the trainer.

    Attributes:
        answered: the answered questions, in words, oldest first.
    """

    def __init__(self, trainer: Trainer) -> None:
        self.answered: list[str] = []
        self._trainer = trainer
        self._log = trainer.log
        self._asks = False
        self._situations = SituationSample()
        domain, features = trainer.context.repertoire.domain, trainer.curriculum.features
        readable = trainer.history.readable
        self._discrete = [
            readable.index(term)
            for term in features
            if term not in TIMERS and not domain.scale_of(term).kind.is_measured
        ]
        self._numbers: dict[tuple[Any, ...], int] = {}
        self._dismissed: set[tuple[str, ...]] = set()
        self._about: tuple[Example, ...] | None = None
        self._contradicting: list[Question] = []
        self._known: list[Question] = []
        self._with_effects: dict[int, Question] = {}  # with the effects of their answers
        self._searched: Hashable = None

    def subscribe(self) -> None:
        """Start to collect situations and examples."""
        self._asks = True
        events = self._trainer.events
        events.perceived.subscribe(self._meet)
        events.begun.subscribe(self._begin)
        events.changed.subscribe(self._see_change)

    def _meet(self, moment: PerceptRecord) -> None:
        values = (moment.readings[i] for i in self._discrete)
        kind = (moment.state, *(None if math.isnan(value) else value for value in values))
        self._situations.add(kind, moment)

    def _begin(self, moment: PerceptRecord | None) -> None:
        if moment is not None:
            self._situations.forget_from(moment.time)
            self._meet(moment)

    def _see_change(self, record: Mapping[str, Any]) -> None:
        if record["do"] == "dismiss":
            self._dismissed.add(tuple(record["key"]))

    @property
    def news(self) -> tuple[int, int]:
        """Counter that changes when situations of a new kind, or many more, have been met."""
        return self._situations.news

    def known(self) -> list[Question]:
        """Return the open questions, without a search that takes long.

        These are all contradictions, and the most useful one of the others.
        """
        self._look_at_examples()
        return [self._with_effects.get(question.number, question) for question in self._asked()]

    def _asked(self) -> list[Question]:
        asked = [question for question in self._known if question.words not in self._dismissed]
        others = [q for q in asked if q.kind is not QuestionKind.CONTRADICTION]
        return [q for q in asked if q not in others[1:]]

    def _look_at_examples(self) -> None:
        """Find the contradictions, if the examples have changed."""
        log = self._log
        if self._asks and self._about is not log.examples:
            self._about, self._searched, self._with_effects = log.examples, None, {}
            self._known = self._contradicting = self._contradictions(log.contradictory())

    def find(self) -> list[Question]:
        """Return the open questions after a search, which can take a tenth of a second.

        Raises:
            TrainingError, FeatureValueError, VocabularyError: see `Evidence.learn`.
        """
        for _ in self.search():
            pass
        return self.known()

    def search(self) -> Iterator[None]:
        """Look for questions, for `find`, in steps between which something else can be done.

        The effects of answers to the first questions are computed, too. If the examples change
        meanwhile, the search ends; begin another one.

        Raises:
            TrainingError, FeatureValueError, VocabularyError: see `Evidence.learn`.
        """
        if not self._asks:
            return
        self._look_at_examples()
        examples, news = self._about, self._situations.news
        if self._searched != news:
            given = _Material(self._trainer, self._situations)
            found: list[tuple[float, Question]] = []
            for ranked in self._found(given):
                if ranked is not None:
                    found.append(ranked)
                yield
                if self._about is not examples:
                    return
            found.sort(key=lambda ranked: -ranked[0])
            # Open questions stay: a person may be reading one, or about to answer it.
            asked = [q for q in self._asked() if q not in self._contradicting]
            others = [question for _, question in found if question not in asked]
            self._known = [*self._contradicting, *asked, *others]
            self._searched = news
        new = [q for q in self._asked()[:WITH_EFFECTS_MAX] if q.number not in self._with_effects]
        if new:
            given = _Material(self._trainer, self._situations)
            if ClassifierSpec.parse(given.classifier).name != TREE:
                return
            evidence = {state: given.evidence(state) for state in (START, *given.labels)}
        for question in new:
            choices = []
            for choice in question.choices:
                decisions: list[Changed] = []
                for changes in self._changes(choice, question, given, evidence):
                    decisions += changes
                    yield
                    if self._log.examples is not examples:
                        return
                effect = question_texts.effect(choice.effect, decisions)
                choices.append(replace(choice, effect=effect))
            self._with_effects[question.number] = replace(question, choices=tuple(choices))

    def get(self, number: int) -> Question:
        """Return an open question.

        Raises:
            TrainingError: if it is not open, saying why.
            FeatureValueError, VocabularyError: see `find`.
        """
        found = self.find()
        for question in found:
            if question.number == number:
                return question
        there = [question.number for question in found]
        if number in self._numbers.values():
            raise TrainingError(
                f"question {number} is no longer open: it was answered, or the examples have "
                f"changed {has(there)}"
            )
        raise TrainingError(f"no question {number} {has(there)}")

    def _question(
        self,
        kind: QuestionKind,
        about: tuple[Any, ...],
        text: str,
        state: str,
        choices: tuple[Choice, ...],
        examples: tuple[int, ...] = (),
        situation: tuple[float, ...] = (),
    ) -> Question:
        """Return a question, with its number if it came up before about the same."""
        key = (kind, *about)
        number = self._numbers.setdefault(key, len(self._numbers) + 1)
        return Question(number, kind, text, state, examples, choices, situation, key)

    def _changes(
        self,
        choice: Choice,
        question: Question,
        given: _Material,
        evidence: Mapping[str, Evidence],
    ) -> Iterator[list[Changed]]:
        """Yield the decisions in met situations that an answer changes, state by state."""
        edit = self._log.prepared(choice.record or {"do": ""}) or Edit()
        examples = self._log.after(edit)
        states = (question.state, *(e.state for e in (*edit.gone, *edit.came)))
        for state in dict.fromkeys(states):
            met = [values for there, values in given.met if there == state]
            asked = [question.situation] if state == question.state else []
            yield changed(evidence[state], given.evidence(state, examples), [*asked, *met])

    # -- finding ----------------------------------------------------------------------------

    def _found(self, given: _Material) -> Iterator[tuple[float, Question] | None]:
        """Yield questions that take long to find, with the gain of an answer; None in between."""
        for state in (START, *given.labels):
            if state in FLAGS:
                continue
            evidence = given.evidence(state)
            found = unshown(evidence, *_about(state, given))
            if found is not None:
                yield found.gain, self._of_unshown(found, evidence)
            yield None

    def _contradictions(self, examples: Sequence[Example]) -> list[Question]:
        recorded: dict[int, list[int]] = {}
        for e in examples:
            recorded.setdefault(e.command or -e.number, []).append(e.number)
        found = []
        for group in contradictions(examples):
            choices = []
            for label in _weighed(group):
                wrong = {e.command or -e.number for e in group if e.next_state != label}
                gone = sorted(number for command in wrong for number in recorded[command])
                effect = f"deletes {numbered('example', gone)}"
                choices.append(Choice(label, effect, {"do": "delete_examples", "numbers": gone}))
            numbers = tuple(example.number for example in group)
            text, state, place = question_texts.commanded(group), group[0].state, group[0].features
            answers = tuple(choices), numbers, place
            kind = QuestionKind.CONTRADICTION
            found.append(self._question(kind, (numbers,), text, state, *answers))
        return sorted(found, key=lambda question: -max(question.examples))

    def _of_unshown(self, found: Unshown, evidence: Evidence) -> Question:
        state, place = found.state, found.situation
        text = question_texts.never_shown(found, evidence)
        choices = _commands(state, place, found.next_states, bisects=found.bisects)
        about = (state, place)
        return self._question(QuestionKind.UNSHOWN, about, text, state, choices, situation=place)


def _about(
    state: str, given: _Material
) -> tuple[list[tuple[float, ...]], tuple[str, ...], Booleans]:
    """Return the situations met in a state, its possible answers, and the assumed entries."""
    met = [values for there, values in given.met if there == state]
    met += [e.features for e in given.examples if e.state != state == e.next_state]
    own = [e for e in given.examples if e.state == state and e.is_learned]
    # A default example without an ordinary one answers a question.
    commanded = {e.command for e in given.examples if not e.is_default}
    assumed = [e.is_default and e.command in commanded for e in own]
    return met, given.goals, np.array(assumed, np.bool_)


def _commands(
    state: str, situation: Sequence[float], labels: Sequence[str], *, bisects: bool = False
) -> tuple[Choice, ...]:
    """Return the answers to a question about a situation, one for each different label."""
    choices = []
    for label in dict.fromkeys(labels):
        if label != START:
            record = added(state, situation, label, bisects=bisects)
            choices.append(Choice(label, question_texts.answered(state, label), record))
    return tuple(choices)


def _weighed(group: Sequence[Example]) -> list[str]:
    """Return the next states of examples in the same situation, by weight, the heaviest first.

    A correction counts for `CORRECTED` others, since the person has seen the effect of these. Of
    next states with the same weight, the one commanded last comes first.
    """
    weights: dict[str, int] = {}
    for example in reversed(group):
        weight = CORRECTED if example.kind is ExampleKind.CORRECTION else 1
        weights[example.next_state] = weights.get(example.next_state, 0) + weight
    return sorted(weights, key=lambda label: -weights[label])
