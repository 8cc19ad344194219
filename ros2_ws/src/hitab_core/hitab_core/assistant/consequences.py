"""Consequences of answers: the decisions that they change, and what would be done then.

Every answer is played on over the situations that were met, with the trees that would be learned.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

from hitab_core.advice.changed import Changed, changed, decided
from hitab_core.advice.evidence import Evidence
from hitab_core.assistant import question_texts
from hitab_core.assistant.material import Material
from hitab_core.assistant.question import Choice, Question
from hitab_core.automaton import FLAGS, START, as_entered
from hitab_core.training.percepts import PerceptRecord
from hitab_core.training.trainer import Trainer
from hitab_core.training.undo import Edit

PLAYED_SECONDS = 3.0
"""Simulated time for which an answer is played on, s: what comes of it is seen at a glance."""


Decisions = Mapping[str, Sequence[str]]
"""The decisions in the situations met, by state."""


def weighed(question: Question, given: Material, trainer: Trainer) -> Iterator[Question | None]:
    """Yield the question with the consequences of its answers, and None before, in short steps.

    Raises:
        TrainingError: if an answer is not possible any more.
        FeatureValueError, VocabularyError, ValueError: see `Evidence.learn`.
    """
    choices: list[Choice] = []
    answered: list[Decisions] = []
    for choice in question.choices:
        edit = trainer.prepared(choice.record) or Edit()
        examples = trainer.log.after(edit)
        touched = dict.fromkeys([question.state, *(e.state for e in (*edit.gone, *edit.came))])
        evidence: dict[str, Evidence] = {}
        decisions: dict[str, Sequence[str]] = {}
        changes: list[Changed] = []
        share = 0
        for state in touched:
            after = evidence[state] = given.learnable(state, examples)
            before, met = given.evidence(state), given.met_in(state)
            asked = [question.situation] if question.situation and state == question.state else []
            changes += changed(before, after, [*asked, *met])
            decisions[state] = decided(after, met)
            share += sum(map(str.__ne__, decisions[state], given.decisions(state)))
            yield None
        runs = _played(question, given, evidence, trainer)
        yield None
        weighed_choice = replace(
            choice,
            effect=question_texts.effect(choice.effect, changes),
            changes=share / max(1, len(given.met)),
            cycles=tuple(cycle for cycle, _ in runs),
            states=tuple(state for _, state in runs),
        )
        choices.append(weighed_choice)
        answered.append(decisions)
    matters = _between(answered[0], answered[1], given) if len(choices) > 1 else 0.0
    yield replace(question, choices=tuple(choices), matters=matters)


def _between(one: Decisions, other: Decisions, given: Material) -> float:
    """Return the part of the situations met that two answers decide otherwise."""
    differ = 0
    for state in {*one, *other}:
        ours, theirs = (of.get(state) or given.decisions(state) for of in (one, other))
        differ += sum(map(str.__ne__, ours, theirs))
    return differ / max(1, len(given.met))


def _played(
    question: Question, given: Material, after: Mapping[str, Evidence], trainer: Trainer
) -> list[tuple[int, str]]:
    """Return from which cycles on it would be in which states, over the percepts that were met."""
    features = trainer.curriculum.features
    moments = trainer.history.following(question.cycle, PLAYED_SECONDS) if question.cycle else ()
    if not moments and question.situation:
        moments = [PerceptRecord(question.cycle, 0.0, question.state, ())]
    states, state, entered = [], question.state, 0.0
    for moment in moments:
        values = given.in_moment(moment) if moment.readings else question.situation
        if state != moment.state:
            values = as_entered(features, values, moment.time - entered)
        tree = (after.get(state) or given.evidence(state)).learn()
        decision = state if tree is None else str(tree.predict([values])[0])
        if decision != state:
            entered = moment.time
        states.append((moment.cycle, decision))
        state = START if decision in FLAGS else decision
    return [next(run) for _, run in groupby(states, key=lambda one: one[1])]
