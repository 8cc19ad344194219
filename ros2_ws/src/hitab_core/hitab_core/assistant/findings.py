"""Findings: what is open in a training, as questions.

Each finder looks for questions of some kinds. An answer is a step of the training.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from hitab_core.advice.rivals import Rival, rival
from hitab_core.advice.unshown import Unshown, unshown
from hitab_core.assistant import question_texts
from hitab_core.assistant.doubts import Doubt
from hitab_core.assistant.material import Material
from hitab_core.assistant.question import Choice, Question, QuestionKind, added
from hitab_core.automaton import FLAGS, START
from hitab_core.example import Example, ExampleKind, contradictions
from hitab_core.numeric.arrays import Booleans
from hitab_core.texts.wording import numbered

CORRECTED = 2
"""Number of other commands that a correction outweighs evenly."""


class Ask(Protocol):
    """Makes a question, with the number that it had before if it came up before."""

    def __call__(self, kind: QuestionKind, about: tuple[Any, ...], **fields: Any) -> Question:
        """Return a question.

        Args:
            kind: kind of the question.
            about: what makes it another question than others of its kind.
            fields: of the question.
        """


def contradicting(examples: Sequence[Example], ask: Ask) -> list[Question]:
    """Return a question for each place where commands contradict each other."""
    recorded: dict[int, list[int]] = {}
    for e in examples:
        recorded.setdefault(e.command or -e.number, []).append(e.number)
    found = []
    for group in contradictions(examples):
        choices, weights = [], _weights(group)
        for label in sorted(weights, key=lambda label: -weights[label]):
            wrong = {e.command or -e.number for e in group if e.next_state != label}
            gone = sorted(number for command in wrong for number in recorded[command])
            effect = f"deletes {numbered('example', gone)}"
            choices.append(Choice(label, effect, {"do": "delete_examples", "numbers": gone}))
        first, second = (weights[choice.name] for choice in choices[:2])
        decisive = first > second or group[-1].kind is ExampleKind.CORRECTION
        numbers = tuple(example.number for example in group)
        question = ask(
            QuestionKind.CONTRADICTION,
            (numbers,),
            text=question_texts.commanded(group),
            state=group[0].state,
            examples=numbers,
            choices=tuple(choices),
            situation=group[0].features,
            proposed=choices[0].name if decisive else "",
            cycle=group[-1].cycle,
        )
        found.append(question)
    return sorted(found, key=lambda question: -max(question.examples))


def never_shown(given: Material, ask: Ask) -> Iterator[tuple[float, Question] | None]:
    """Yield questions about situations that were never shown, with the gain of an answer.

    Where another feature explains the examples as well, the situation is one in which the two
    explanations decide otherwise. None comes in between.
    """
    for state in (START, *given.labels):
        if state in FLAGS:
            continue
        evidence = given.evidence(state)
        met = given.met_in(state)
        found = unshown(evidence, met, given.goals, _assumed(state, given))
        if found is not None:
            yield found.gain, _of_unshown(found, given, ask)
        yield None
        rivals: list[Rival] = []
        for one in rival(evidence, met):
            rivals += [one] if one is not None else []
            yield None
        if rivals:
            most = max(rivals, key=lambda one: one.part)
            yield most.part, _of_rival(most, given, ask)


def ambiguous(given: Material, doubts: Mapping[int, Doubt], ask: Ask) -> Iterator[Question]:
    """Yield questions about late commands that may be meant for either of two moments."""
    for e in given.examples:
        doubt = doubts.get(e.command)
        if doubt is None or e.is_default:
            continue
        choices = []
        for moment in (doubt.likely, doubt.other):
            ago = max(0.0, doubt.time - moment.time)
            record = {"do": "retime_examples", "numbers": [e.number], "ago": ago}
            effect = question_texts.due(moment.state, ago)
            values = given.in_moment(moment)
            choices.append(Choice(f"{ago:.2f} s before", effect, record, moment.state, values))
        first = min(doubt.likely, doubt.other, key=lambda moment: moment.time)
        same = doubt.likely.state == doubt.other.state
        kind = QuestionKind.LATE if same else QuestionKind.CORRECTION
        yield ask(
            kind,
            (e.command, *sorted((doubt.likely.cycle, doubt.other.cycle))),
            text=question_texts.ambiguous(e, choices),
            state=first.state,
            examples=(e.number,),
            choices=tuple(choices),
            cycle=first.cycle,
        )


def _assumed(state: str, given: Material) -> Booleans:
    """Return which of the examples of a state come from its entry."""
    own = [e for e in given.examples if e.state == state and e.is_learned]
    # A default example without an ordinary one answers a question.
    commanded = {e.command for e in given.examples if not e.is_default}
    return np.array([e.is_default and e.command in commanded for e in own], np.bool_)


def _of_unshown(found: Unshown, given: Material, ask: Ask) -> Question:
    state, place = found.state, found.situation
    return ask(
        QuestionKind.UNSHOWN,
        (state, place),
        text=question_texts.never_shown(found, given.evidence(state)),
        state=state,
        choices=_commands(state, place, found.next_states, bisects=found.bisects),
        situation=place,
        proposed=found.decided if found.supported else "",
        cycle=given.cycle_of(state, place),
    )


def _of_rival(found: Rival, given: Material, ask: Ask) -> Question:
    state, place = found.state, found.situation
    labels = (found.decided, found.otherwise, *given.goals)
    return ask(
        QuestionKind.FEATURE,
        (state, place),
        text=question_texts.which_feature(found, given.evidence(state)),
        state=state,
        choices=_commands(state, place, labels, bisects=True),
        situation=place,
        cycle=given.cycle_of(state, place),
    )


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


def _weights(group: Sequence[Example]) -> dict[str, int]:
    """Return the weights of the next states of examples in the same situation, the last first.

    A correction counts for `CORRECTED` others, since the person has seen the effect of these.
    """
    weights: dict[str, int] = {}
    for example in reversed(group):
        weight = CORRECTED if example.kind is ExampleKind.CORRECTION else 1
        weights[example.next_state] = weights.get(example.next_state, 0) + weight
    return weights
