"""Finds out why a robot did the wrong thing: a mistaken example, or too few examples.

A person who corrects a robot says that the function of one state decided wrongly in one situation.
Either an example there says what the person did not mean, or no example says what the person means
there. The first is put right by removing the example, the second by the correction itself and
perhaps one more example. To tell them apart,

- each example of the state is judged by its neighbors (`hitab_core.advice.neighbors`), among which
  corrections count fully, since the person has just confirmed them; so one correction right beside
  an example, or several around it, make it a mistake, and one far off does not;
- a command that comes a little early or late is no mistake: where there are few examples, one that
  would be right if a value were somewhat different must be contradicted more clearly;
- a command counts as a whole: what contradicts its default example, in the next state, speaks
  against the command as well, if less;
- the function is learned again without the example, which shows what removing it changes.

The objective is that of Sullivan and others: change the examples instead of relying on a
classifier that is insensitive to noise. They look where the classifier was misled, at a leaf or at
near examples; here all corrections so far are weighed together, as a probability, and what
removing an example changes is tried out.

References:
    K. Sullivan, A. ElMolla, B. Squires, S. Luke, Unlearning from Demonstration, IJCAI 2013.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hitab_core.advice import reasons
from hitab_core.advice.case import Case, Place, as_shown
from hitab_core.advice.proposals import Correction, Proposal, ProposalKind
from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example
from hitab_core.learning.transition_learning import Learn
from hitab_core.transition_function import LearnedTransition

LIKELY = 0.3
"""Least probability of a mistake that is proposed: overlooking one costs more than asking."""

MANY = 20
"""Number of examples of a state above which one more or less hardly matters."""

LIKELY_OF_MANY = 0.15
"""Least probability of a mistake that is proposed where there are many examples."""

TRIED = 60
"""Most examples of a state that are tried out one by one; more take too long."""

CLEARLY = 0.75
"""Least probability of a mistake that is proposed without a correction, or where a wavering
threshold explains it, too."""

WAVERING = (0.85, 0.93, 1.07, 1.15)
"""Factors by which a person's idea of a threshold varies from command to command."""

HEARSAY = 0.5
"""Weight of what speaks against a default example, against its command."""

EVEN = 0.1
"""If two examples contradict each other and no more than this speaks for one, nobody can tell."""


def propose(
    examples: Sequence[Example],
    scales: Sequence[Scale],
    corrections: Sequence[Correction],
    learn: Learn | None = None,
    names: Sequence[str] | None = None,
) -> list[Proposal]:
    """Return what would put right the decisions that were corrected: mistakes first, surest first.

    Args:
        examples: of an automaton. Those of the corrected states are judged; the values of all show
            what usual differences are, and a command has a default example in another state.
        scales: how the values of each feature compare.
        corrections: all so far, oldest first; each counts.
        learn: learns the function of a state; C4.5 by default.
        names: of the features, for the texts; ``feature 0``, ``feature 1``, ... by default.

    Raises:
        TrainingError: naming an example or a correction that lacks values.
    """
    case = Case.of(examples, scales, corrections, learn, names)
    found: dict[tuple[ProposalKind, tuple[int, ...], tuple[int, ...]], Proposal] = {}
    for state in dict.fromkeys(correction.state for correction in corrections):
        for proposal in _proposals(case, state):
            about = proposal.corrections if proposal.kind is ProposalKind.SPARSE else ()
            key = (proposal.kind, proposal.examples, about)
            if key not in found or found[key].score < proposal.score:
                found[key] = proposal
    return sorted(
        found.values(),
        key=lambda p: (p.kind is ProposalKind.SPARSE, -p.score, p.examples, p.corrections),
    )


def suspects(
    examples: Sequence[Example],
    scales: Sequence[Scale],
    names: Sequence[str] | None = None,
    *,
    among: Sequence[int] | None = None,
) -> list[Proposal]:
    """Return ordinary examples that those around them contradict, the surest first.

    Nobody has complained of them, so more must speak against them than against those that led to a
    correction. To judge a command when it is recorded, look ``among`` its examples alone.

    Args:
        examples, scales, names: see `propose`.
        among: numbers of the examples to be judged; None: all.

    Raises:
        TrainingError: naming an example that lacks values.
    """
    case = Case.of(examples, scales, (), None, names)
    found = []
    for state in dict.fromkeys(example.state for example in case.examples):
        place = case.place(state)
        for row in _suspicious(place, CLEARLY):
            if among is None or place.own[row].number in among:
                tried = len(place.own) <= TRIED
                found.append(reasons.mistake(case, place, row, tried=tried))
    return sorted(found, key=lambda p: (-p.score, p.examples))


def contradictions(examples: Sequence[Example]) -> list[Proposal]:
    """Return groups of ordinary examples that differ in nothing but the next state.

    No function can obey them all; a tree draws one of them at random in each tick.
    """
    groups: dict[tuple[str, tuple[float | None, ...]], list[Example]] = {}
    for example in examples:
        if not example.is_default:
            groups.setdefault((example.state, example.point), []).append(example)
    return [
        reasons.contradiction(group)
        for group in groups.values()
        if len({example.next_state for example in group}) > 1
    ]


def _suspicious(place: Place, least: float) -> list[int]:
    """Return the positions of ordinary examples that are likely mistakes, the likeliest first.

    Of two that speak against each other above all, at most one is a mistake.
    """
    chance = place.around.mistaken[: len(place.own)]
    found = [
        row
        for row in np.argsort(-chance, kind="stable").tolist()
        if chance[row] >= least and not place.own[row].is_default
    ]
    against = {row: place.accuser(row) for row in found}
    return [
        row
        for row, other in against.items()
        if against.get(other) != row or chance[row] > chance[other] + EVEN
    ]


def _proposals(case: Case, state: str) -> list[Proposal]:
    """Return the proposals for one state that was corrected."""
    place = case.place(state)
    before = case.learned(place.own)
    wrong = {j: c for j, c in place.corrected.items() if case.decides(before, c) != c.right}
    tried = len(place.own) <= TRIED
    if len(place.own) > MANY:
        suspicious = _suspicious(place, LIKELY_OF_MANY)
    else:
        suspicious = [
            row
            for row in _suspicious(place, LIKELY)
            if place.around.mistaken[row] >= CLEARLY or not _may_waver(case, place, row)
        ]
    doubted = [place.own[row] for row in suspicious]
    together = case.learned([e for e in place.own if e not in doubted])
    found, answered = [], set()
    for row in suspicious:
        example = place.own[row]
        answers = [
            j
            for j, c in wrong.items()
            if c.wrong == example.next_state
            and (place.is_correction(place.accuser(row)) or case.decides(together, c) == c.right)
        ]
        if tried:
            alone = case.learned([other for other in place.own if other is not example])
            answers += [
                j
                for j, c in wrong.items()
                if j not in answers and case.decides(alone, c) == c.right
            ]
        answered |= {*answers}
        found.append(reasons.mistake(case, place, row, sorted(answers), tried=tried))
    for proposal in _retracted(case, place):
        answered |= {*proposal.corrections}
        found.append(proposal)
    for j in wrong:
        if j not in answered:
            deciders = _deciders(case, place, before, j)
            doubt = max((float(place.around.mistaken[row]) for row in deciders), default=0.0)
            found.append(reasons.sparse(case, place, deciders, j, 1 - doubt))
    return found


def _may_waver(case: Case, place: Place, row: int) -> bool:
    """Return whether the others would agree with an example if its values varied a little."""
    example = place.own[row]
    function = case.taught(place, example)
    if function is None:
        return False
    for f, scale in enumerate(case.scales):
        value = example.features[f]
        if not scale.kind.is_measured or math.isnan(value):
            continue
        if scale.kind is FeatureKind.TOROIDAL:
            value = math.remainder(value, scale.period)
        for factor in WAVERING:
            varied = (*example.features[:f], value * factor, *example.features[f + 1 :])
            if case.decides(function, as_shown(example, varied)) == example.next_state:
                return True
    return False


def _deciders(case: Case, place: Place, before: LearnedTransition | None, index: int) -> list[int]:
    """Return the positions of the examples that a wrong decision rests on, the nearest first.

    They are those that say what was decided and pass the same tests.
    """
    if before is None:
        return []
    correction = place.corrected[index]
    near = place.nearest(len(place.own) + [*place.corrected].index(index))
    saying = [
        row for row in near if not place.is_correction(row) and place.said(row) == correction.wrong
    ]
    path = case.explain(before, correction.features).tests
    leaf = [row for row in saying if case.explain(before, place.own[row].features).tests == path]
    return leaf or saying


def _retracted(case: Case, place: Place) -> list[Proposal]:
    """Return commands that led to this state and were put right in it, in about that situation.

    Their ordinary examples are in the states before; here are their default examples.
    """
    found = []
    for row, example in enumerate(place.own):
        put_right = place.is_correction(place.accuser(row)) and example.is_default
        if not put_right or not example.command or place.around.mistaken[row] < LIKELY:
            continue
        answers = [j for j, c in place.corrected.items() if c.wrong == example.next_state]
        for origin in case.examples:
            if origin.command == example.command and origin.state != place.state:
                there = case.place(origin.state)
                chance = _with_hearsay(
                    float(there.around.mistaken[there.own.index(origin)]) or place.around.share,
                    float(place.around.mistaken[row]),
                    place.around.share,
                )
                if chance >= LIKELY:
                    found.append(reasons.retraction(case, place, row, origin, chance, answers))
    return found


def _with_hearsay(chance: float, default: float, share: float) -> float:
    """Return the probability of a mistake given that of its default example as well."""
    odds = _log_odds(chance) + HEARSAY * (_log_odds(default) - _log_odds(share))
    return 1 / (1 + math.exp(-odds))


def _log_odds(p: float) -> float:
    bounded = min(max(p, 1e-6), 1 - 1e-6)
    return math.log(bounded / (1 - bounded))
