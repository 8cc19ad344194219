"""What an agent asks its demonstrator about the examples of a training, and what answers do.

There are four kinds of questions. Two commands in the same situation contradict each other; an
example made the agent do what was then corrected, and was perhaps a mistake; the examples say too
little somewhere; several explanations fit the examples. Each is found again from the examples as
they are (`hitab_core.advice`), so an answer that changes them ends its question, and undoing the
answer asks it again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from hitab_core.advice.ambiguity import Ambiguity, ambiguities
from hitab_core.advice.evidence import Evidence, answer_kind
from hitab_core.advice.mistakes import contradictions, propose, suspects
from hitab_core.advice.proposals import Correction, Proposal, ProposalKind
from hitab_core.automaton import START
from hitab_core.domain import Scale
from hitab_core.errors import TrainingError
from hitab_core.example import Example
from hitab_core.vocabulary import has
from hitab_core.wording import numbered

REMOVE, KEEP = "remove", "keep"


class QuestionKind(StrEnum):
    """What a question is about."""

    CONTRADICTION = "contradiction"
    MISTAKE = "mistake"
    SPARSE = "sparse"
    AMBIGUITY = "ambiguity"


@dataclass(frozen=True)
class Choice:
    """One answer to a question.

    Attributes:
        name: what the person says.
        effect: what it does, for people.
        record: the step of the training that it is, as the journal records it; None: nothing is
            changed, and the question is not asked again.
    """

    name: str
    effect: str
    record: Mapping[str, Any] | None


@dataclass(frozen=True)
class Question:
    """A question to the demonstrator.

    Attributes:
        number: unique within the training.
        kind: what it is about.
        text: the question.
        state: label of the state whose decision it is about.
        examples: numbers of the examples that it is about.
        choices: what can be answered; the first one is proposed.
        situation: values of the automaton's features in which to decide; NaN: any. Empty: none.
        key: what makes it the same question again.
    """

    number: int
    kind: QuestionKind
    text: str
    state: str
    examples: tuple[int, ...]
    choices: tuple[Choice, ...]
    situation: tuple[float, ...] = ()
    key: tuple[Any, ...] = field(default=(), repr=False)

    @property
    def words(self) -> tuple[str, ...]:
        """The key as plain data, for the journal."""
        return tuple(map(str, self.key))


@dataclass(frozen=True)
class Material:
    """What questions are found from.

    Attributes:
        examples: of the training.
        scales, names, units: of the features.
        classifier: that learns from them.
        labels: of the states, without Start.
        corrections: of what the automaton did by itself.
        perceived: the features' values in what was perceived, each with the state of that time.
    """

    examples: tuple[Example, ...]
    scales: tuple[Scale, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    classifier: str
    labels: tuple[str, ...]
    corrections: tuple[Correction, ...] = ()
    perceived: tuple[tuple[str, tuple[float, ...]], ...] = ()


class Questions:
    """The questions of one training, numbered as they come up.

    Attributes:
        answered: what was answered, in words, oldest first.
    """

    def __init__(self) -> None:
        self.answered: list[str] = []
        self._numbers: dict[tuple[Any, ...], int] = {}
        self._dismissed: set[tuple[str, ...]] = set()
        self._about: tuple[Example, ...] | None = None
        self._known: list[Question] = []
        self._searched = False

    def count(self, examples: tuple[Example, ...]) -> int:
        """Return how many are open, without looking for those that take long to find."""
        self._look_at(examples)
        return len(self._unless_dismissed(self._known))

    def _look_at(self, examples: tuple[Example, ...]) -> None:
        """Look for those that are found at once, if the examples have changed."""
        if self._about is not examples:
            self._about, self._searched = examples, False
            self._known = self._contradictions(examples)

    def find(
        self, material: Callable[[], Material], examples: tuple[Example, ...]
    ) -> list[Question]:
        """Return those that are open, the most useful first; this can take a tenth of a second.

        Args:
            material: returns what they are found from; called if the examples have changed.
            examples: of the training.

        Raises:
            TrainingError, FeatureValueError, VocabularyError: as learning from the examples.
        """
        self._look_at(examples)
        if not self._searched:
            self._known = [*self._known, *self._found(material(), self._known)]
            self._searched = True
        return self._unless_dismissed(self._known)

    def get(self, number: int, found: Sequence[Question]) -> Question:
        """Return an open question.

        Raises:
            TrainingError: if it is not open, saying why.
        """
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

    def dismiss(self, key: Iterable[str]) -> None:
        """Do not ask a question again, given `Question.words`."""
        self._dismissed.add(tuple(key))

    def _unless_dismissed(self, found: Iterable[Question]) -> list[Question]:
        return [question for question in found if question.words not in self._dismissed]

    def _number(self, key: tuple[Any, ...]) -> int:
        return self._numbers.setdefault(key, len(self._numbers) + 1)

    # -- finding ----------------------------------------------------------------------------

    def _found(self, given: Material, known: Sequence[Question]) -> list[Question]:
        """Return those that take long to find, besides those that are known."""
        found: list[Question] = []
        contradicted = {number for question in known for number in question.examples}
        proposals = propose(
            given.examples, given.scales, given.corrections, None, given.names
        ) + suspects(given.examples, given.scales, given.names)
        for proposal in proposals:
            if contradicted.isdisjoint(proposal.examples):
                question = self._of_proposal(proposal, given)
                if question is not None and question.number not in {q.number for q in found}:
                    found.append(question)
        for state in (START, *given.labels):
            evidence = Evidence.of(
                state, given.examples, given.scales, given.names, given.units, given.classifier
            )
            if len(set(evidence.next_states)) < 2:
                continue
            here = [at == state for at, _ in given.perceived]
            for ambiguity in ambiguities(
                evidence, readings=[values for _, values in given.perceived], here=here
            ):
                found.append(self._of_ambiguity(ambiguity, given))
        return found

    def _contradictions(self, examples: tuple[Example, ...]) -> list[Question]:
        by_number = {example.number: example for example in examples}
        found = []
        for proposal in contradictions(examples):
            group = [by_number[number] for number in proposal.examples]
            newest_first = dict.fromkeys(e.next_state for e in reversed(group))
            choices = []
            for label in newest_first:
                wrong = {e.command or -e.number for e in group if e.next_state != label}
                gone = [e.number for e in examples if (e.command or -e.number) in wrong]
                choices.append(
                    Choice(
                        label,
                        f"deletes {numbered('example', gone)}",
                        {"do": "delete", "numbers": gone},
                    )
                )
            key = (QuestionKind.CONTRADICTION, proposal.examples)
            found.append(
                Question(
                    self._number(key),
                    QuestionKind.CONTRADICTION,
                    f"{'; '.join(proposal.evidence)}: which holds?",
                    proposal.state,
                    proposal.examples,
                    tuple(choices),
                    group[0].features,
                    key,
                )
            )
        return found

    def _of_proposal(self, proposal: Proposal, given: Material) -> Question | None:
        text = "; ".join(proposal.evidence)
        if proposal.kind is ProposalKind.MISTAKE:
            key = (QuestionKind.MISTAKE, proposal.examples)
            choices = [
                Choice(
                    REMOVE,
                    proposal.change,
                    {"do": "delete", "numbers": list(proposal.examples)},
                ),
                Choice(KEEP, "changes nothing", None),
            ]
            text = f"Was {numbered('example', proposal.examples)} a mistake? {_sentence(text)}"
            return Question(
                self._number(key),
                QuestionKind.MISTAKE,
                text,
                proposal.state,
                proposal.examples,
                tuple(choices),
                key=key,
            )
        if proposal.kind is not ProposalKind.SPARSE or proposal.place is None:
            return None
        where: tuple[Any, ...] = (QuestionKind.SPARSE, proposal.state, proposal.place)
        labels = [label for label in (proposal.instead, *given.labels) if label]
        return Question(
            self._number(where),
            QuestionKind.SPARSE,
            f"What is right in {proposal.state} here? {_sentence(text)}",
            proposal.state,
            proposal.examples,
            tuple(
                Choice(
                    label,
                    "adds an example",
                    added(proposal.state, proposal.place, label),
                )
                for label in dict.fromkeys(labels)
            ),
            proposal.place,
            where,
        )

    def _of_ambiguity(self, ambiguity: Ambiguity, given: Material) -> Question:
        key = (QuestionKind.AMBIGUITY, *ambiguity.key)
        return Question(
            self._number(key),
            QuestionKind.AMBIGUITY,
            ambiguity.text,
            ambiguity.state,
            (),
            tuple(
                Choice(
                    side.next_state,
                    f"adds an example: {side}",
                    added(ambiguity.state, ambiguity.situation, side.next_state),
                )
                for side in (ambiguity.learned, ambiguity.other)
            ),
            ambiguity.situation,
            key,
        )


def added(state: str, situation: Sequence[float], next_state: str) -> Mapping[str, Any]:
    """Return the step of a training that adds an example, as the journal records it."""
    values = [None if math.isnan(value) else value for value in situation]
    kind = answer_kind(state, next_state).value
    return {
        "do": "add",
        "state": state,
        "features": values,
        "next_state": next_state,
        "kind": kind,
    }


def choice_of(question: Question, name: str) -> Choice:
    """Return a choice by its name; empty: the proposed one.

    Raises:
        TrainingError: if there is none of this name.
    """
    if not name:
        return question.choices[0]
    for choice in question.choices:
        if choice.name == name:
            return choice
    there = [choice.name for choice in question.choices]
    raise TrainingError(f'question {question.number} has no choice "{name}" {has(there, name)}')


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}." if text else ""
