"""Unlearning: finds examples that were mistakes, and places where too little was shown.

If a robot is corrected, either an example says what the person did not mean, and removing it puts
that right, or no example says what the person means there, and one more does. To tell them apart,
each example of the state is judged by the others and by all corrections so far, which count fully
since the person has just confirmed them: one correction right beside an example, or several around
it, make it a mistake, and one far off does not.

How likely an example is a mistake follows from the probability of its next state given the others.
Each of these counts with the probability that no boundary lies in between, which falls off
exponentially with the distance (M. Balog and others, The Mondrian Kernel, UAI 2016). Which
features matter, and how sharply votes decide, is taken from how well examples predict one another.
The objective is from K. Sullivan and others, Unlearning from Demonstration, IJCAI 2013.

Not part of the engine, since no simulated person's team was better for it; see unlearning.md.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import product

import numpy as np

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.situation_text import situation_in_words
from hitab_core.default_example import superseding
from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.numeric.arrays import Floats
from hitab_core.numeric.spread import differences, spreads
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.wording import quantity

LIKELY = 0.3
"""Least probability of a mistake that is proposed: overlooking one costs more than asking."""

CLEARLY = 0.8
"""Least probability of a mistake that is proposed without a correction, or if a wavering
threshold explains it, too."""

WAVERING = (0.85, 1.15)
"""How much a person's idea of a threshold varies from command to command."""

MANY = 20
"""Number of examples of a state above which one more or less hardly matters."""

LIKELY_OF_MANY = 0.15
"""Least probability of a mistake that is proposed where there are many examples."""

MISTAKEN = 0.1
"""Expected share of mistaken commands; it counts as much as what ten examples say."""

BOUNDARIES = 5.0
"""How many there usually are per unit of distance, for one feature; more features, more."""

ALONE = 8.0
"""As many, where a feature predicts alone what was said."""

EVEN = 0.1
"""Two examples whose probabilities of a mistake differ by less are about even."""

LOUDNESS = (1.0, 100.0)
"""Weight of all votes against none; above 1 even far examples outvote ignorance."""

SHARPNESS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Exponents of the votes; 1: votes are probabilities."""

TOUCHING = 0.05
"""Boundary probability between two equal situations, since sensors and hands waver."""


class ProposalKind(StrEnum):
    """Why a robot did the wrong thing, and so what to do about it."""

    MISTAKE = "mistake"  # an example says what the person did not mean: remove it
    SPARSE = "sparse"  # too little was shown there: add an example


@dataclass(frozen=True, slots=True)
class Correction:
    """A command against what the automaton did by itself.

    Attributes:
        state: label of the state in which it decided.
        features: the values that it saw, in the order of the automaton's features; NaN: missing.
        wrong: label of the state that it went to, or stayed in.
        right: label of the state that the person commanded.
        number: of the example that the command recorded, 0 if it recorded none. The example with
            this number is not taken for evidence a second time.
        since: number of the last example then; what has a higher one was shown later. 0: unknown.
    """

    state: str
    features: tuple[float, ...]
    wrong: str
    right: str
    number: int = 0
    since: int = 0


@dataclass(frozen=True, slots=True)
class Proposal:
    """Something that the person can accept or decline.

    Attributes:
        kind: remove (`MISTAKE`) or add (`SPARSE`).
        state: label of the state whose transition function is concerned.
        examples: their numbers, ascending. For a mistake, all to be removed, so the default
            example of the command as well; for too few examples, the one that decided.
        instead: the next state that was probably meant.
        score: probability that it is right, 0 to 1.
        evidence: sentences that say why, the strongest first.
        corrections: indices of the corrections that it answers.
        change: of a mistake, what removing it changes, in a sentence.
        place: of too few examples, a situation in which one more command tells most: feature
            values.
    """

    kind: ProposalKind
    state: str
    examples: tuple[int, ...]
    instead: str
    score: float
    evidence: tuple[str, ...]
    corrections: tuple[int, ...] = ()
    change: str = ""
    place: tuple[float, ...] | None = None


def propose(
    examples: Sequence[Example],
    scales: Sequence[Scale],
    corrections: Sequence[Correction],
    names: Sequence[str] = (),
) -> list[Proposal]:
    """Return what would put right the decisions that were corrected: mistakes first, surest first.

    Args:
        examples: of an automaton; the values of all show what usual differences are.
        scales: how the values of each feature compare.
        corrections: all so far, oldest first; each counts.
        names: of the features, for the texts; ``feature 0``, ``feature 1``, ... by default.

    Raises:
        TrainingError: naming an example or a correction that lacks values.
    """
    training = _Training(examples, scales, corrections, names)
    states = dict.fromkeys(correction.state for correction in corrections)
    found = [proposal for state in states for proposal in training.proposals(state)]
    return sorted(found, key=lambda p: (p.kind is ProposalKind.SPARSE, -p.score, p.examples))


def suspects(
    examples: Sequence[Example], scales: Sequence[Scale], names: Sequence[str] = ()
) -> list[Proposal]:
    """Return ordinary examples that the others contradict, the surest first.

    Nobody has complained of them, so more must speak against them than against those that led to a
    correction. For the arguments and errors see `propose`.
    """
    training = _Training(examples, scales, (), names)
    states = [training.shown(s) for s in dict.fromkeys(e.state for e in training.judged)]
    found = [training.mistake(s, row) for s in states for row in s.suspicious(CLEARLY)]
    return sorted(found, key=lambda p: (-p.score, p.examples))


@dataclass(frozen=True, eq=False)
class _Shown:
    """What was shown in one state: rows for examples and, after them, for corrections.

    Attributes:
        own: the examples, without those that corrections recorded.
        corrected: the corrections, by their index among all.
        evidence: all rows.
        apart: shape (n, n), how far rows are apart.
        mistaken: shape (n,), probability that a row is a mistake; 0 for a correction.
    """

    own: tuple[Example, ...]
    corrected: Mapping[int, Correction]
    evidence: Evidence
    apart: Floats
    mistaken: Floats

    def decisions(
        self, values: Floats, *, without: Collection[int] = (), corrections: bool = True
    ) -> list[str]:
        """Return what is decided in situations, shape (k, m), if some rows are not learned."""
        evidence = self.evidence
        count = len(evidence.next_states) if corrections else len(self.own)
        rows = [row for row in range(count) if row not in without]
        if not rows or not len(values):
            return [evidence.state] * len(values)
        tree = TransitionTree(evidence.scales, feature_names=evidence.names)
        said = [evidence.next_states[row] for row in rows]
        tree.fit(evidence.values[rows], said, evidence.default[rows])
        return [str(label) for label in tree.predict(values)]

    def nearest(self, row: int) -> list[int]:
        """Return all other rows, the nearest first."""
        order = np.argsort(self.apart[row], kind="stable").tolist()
        return [other for other in order if other != row]

    def contradicting(self, row: int) -> int:
        """Return the nearest row with another next state; -1 if none has."""
        said = self.evidence.next_states
        return next((other for other in self.nearest(row) if said[other] != said[row]), -1)

    def suspicious(self, least: float) -> list[int]:
        """Return ordinary examples that are likely mistakes.

        Of two that speak against each other above all, at most one is, and if they are about even,
        nobody can tell which.
        """
        chance = self.mistaken
        against = {
            row: self.contradicting(row)
            for row, example in enumerate(self.own)
            if chance[row] >= least and not example.is_default
        }
        return [
            row
            for row, other in against.items()
            if against.get(other) != row or chance[row] > chance[other] + EVEN
        ]

    def may_waver(self, row: int) -> bool:
        """Return whether the others would agree with an example if a value varied a little."""
        varied = []
        for f, scale in enumerate(self.evidence.scales):
            for factor in WAVERING if scale.kind.is_measured else ():
                another = self.evidence.values[row].copy()
                if scale.kind is FeatureKind.TOROIDAL:
                    another[f] = math.remainder(another[f], scale.period)
                another[f] *= factor
                varied.append(another)
        return self.own[row].next_state in self.decisions(np.array(varied), without=(row,))

    def difference(self, row: int, other: int) -> str:
        """Return how two rows differ, in a sentence."""
        said, (mine, its) = self.evidence.next_states, self.evidence.values[[row, other]]
        features = np.flatnonzero((mine != its) & ~np.isnan(mine + its))[:3].tolist()
        here, there = (situation_in_words(self.evidence, v, features) for v in (mine, its))
        who = f"example {self.own[other].number}" if other < len(self.own) else "your correction"
        if not there:
            return f"you showed {said[other]} in the same situation ({who})"
        return f"you showed {said[other]} with {there} ({who}), and {said[row]} with {here}"


class _Training:
    """All that proposals are made from."""

    def __init__(
        self,
        examples: Sequence[Example],
        scales: Sequence[Scale],
        corrections: Sequence[Correction],
        names: Sequence[str],
    ) -> None:
        for what, given in [
            *((f"example {e.number}", e.features) for e in examples),
            *((f"correction {i}", c.features) for i, c in enumerate(corrections, 1)),
        ]:
            if len(given) != len(scales):
                raise TrainingError(
                    f"{what} has {quantity(len(given), 'value')} for "
                    f"{quantity(len(scales), 'feature')}; give one per feature, NaN if missing"
                )
        self._examples, self._corrections, self._scales = examples, corrections, scales
        self._names = names or [f"feature {f}" for f in range(len(scales))]
        recorded = {c.number for c in corrections if c.number}
        others = superseding([e for e in examples if e.number not in recorded])
        # Neither what corrections recorded nor default examples that an ordinary one overrules.
        self.judged = tuple(example for example in others if example.is_learned)
        values = [e.features for e in self.judged] + [c.features for c in corrections]
        table = np.array(values, np.float64).reshape(len(values), len(scales))
        self._spread = spreads(table, scales)
        self._shown: dict[str, _Shown] = {}

    def shown(self, state: str) -> _Shown:
        """Return what was shown in a state."""
        if state not in self._shown:
            own = tuple(example for example in self.judged if example.state == state)
            corrected = {i: c for i, c in enumerate(self._corrections) if c.state == state}
            rows = [*own, *(Example(state, c.features, c.right) for c in corrected.values())]
            evidence = Evidence.of(state, rows, self._scales, self._names)
            apart = distances(evidence.values, self._scales, self._spread)
            judged = _judged(apart, evidence.next_states, len(own))
            self._shown[state] = _Shown(own, corrected, evidence, *judged)
        return self._shown[state]

    def proposals(self, state: str) -> list[Proposal]:
        """Return the proposals for a state that was corrected."""
        shown = self.shown(state)
        many = len(shown.own) > MANY
        found = [
            self.mistake(shown, row)
            for row in shown.suspicious(LIKELY_OF_MANY if many else LIKELY)
            if many or shown.mistaken[row] >= CLEARLY or not shown.may_waver(row)
        ]
        answered = {j for proposal in found for j in proposal.corrections}
        places = np.array([c.features for c in shown.corrected.values()])
        decided = shown.decisions(places, corrections=False)
        for (j, c), label in zip(shown.corrected.items(), decided, strict=True):
            if label != c.right and j not in answered:
                found += _sparse(shown, j)
        return found

    def mistake(self, shown: _Shown, row: int) -> Proposal:
        """Return the proposal to remove a contradicted example, with all of its command."""
        other = shown.contradicting(row)
        example, command = shown.own[row], shown.own[row].command
        same = [e.number for e in self._examples if command and e.command == command]
        return Proposal(
            ProposalKind.MISTAKE,
            example.state,
            tuple(sorted(same or [example.number])),
            shown.evidence.next_states[other],
            float(shown.mistaken[row]),
            (shown.difference(row, other),),
            tuple(j for j, c in shown.corrected.items() if c.wrong == example.next_state),
            _change(shown, row),
        )


def _change(shown: _Shown, row: int) -> str:
    """Return the first difference that removing an example makes where something was shown."""
    evidence, values = shown.evidence, shown.evidence.values
    if len(shown.own) > MANY:
        return f"{evidence.state} is learned again without it"
    before, after = shown.decisions(values), shown.decisions(values, without=(row,))
    for there, was, will in zip(values, before, after, strict=True):
        if was != will:
            where = situation_in_words(evidence, there, range(min(4, len(there))))
            return f"in {evidence.state} with {where} it goes to {will} instead of {was}"
    return f"{evidence.state} decides the same as before where you have shown something"


def _sparse(shown: _Shown, index: int) -> list[Proposal]:
    """Return the proposal to show more between a correction and the example that decided.

    There is none if booleans and categories tell the two apart, or if it has been shown since.
    """
    correction = shown.corrected[index]
    row = len(shown.own) + [*shown.corrected].index(index)
    own = [other for other in shown.nearest(row) if other < len(shown.own)]
    saying = [other for other in own if shown.own[other].next_state == correction.wrong]
    if not saying:
        return []
    nearest, scales = shown.own[saying[0]], shown.evidence.scales
    where, otherwise = [*correction.features], [*nearest.features]
    for f, scale in enumerate(scales):
        way = nearest.features[f] - where[f]
        if scale.kind is FeatureKind.TOROIDAL:
            way = math.remainder(way, scale.period)
        if scale.kind.is_measured and not math.isnan(way):
            where[f] += way / 2
            otherwise[f] = where[f]
    place = tuple(where)
    later = [e.features for e in shown.own if 0 < correction.since < e.number]
    right, wrong = correction.right, correction.wrong
    if {place, nearest.features} & {*later} or place == correction.features:
        return []
    if shown.decisions(np.array([where, otherwise])) == [right, wrong]:
        return []
    why = f"where you corrected it, it went to {wrong}", shown.difference(row, saying[0])
    meant = 1 - float(shown.mistaken[saying[0]])
    about = ProposalKind.SPARSE, correction.state, (nearest.number,)
    return [Proposal(*about, right, meant, why, (index,), place=place)]


def _judged(apart: Floats, next_states: Sequence[str], doubtful: int) -> tuple[Floats, Floats]:
    """Return how far rows are apart, and how likely each is a mistake.

    Given is how far they are apart in each feature, shape (m, n, n), and what they say; those
    after the first ``doubtful`` ones are corrections.
    """
    labels, own = np.unique(np.asarray(next_states), return_inverse=True)
    n, k = len(own), len(labels)
    share, mistaken = MISTAKEN, np.zeros(n)
    if k < 2:
        return np.zeros((n, n)), mistaken
    one_hot = np.eye(k)[own]
    together = np.tensordot(_relevance(apart, one_hot), apart, axes=1)
    same_side = np.exp(-BOUNDARIES * math.sqrt(len(apart)) * together)
    votes = same_side / (1 + TOUCHING - same_side)
    np.fill_diagonal(votes, 0.0)
    settings = [*product(LOUDNESS, SHARPNESS)]
    # How much better than with the usual setting it must predict, in nats.
    costs = [math.log(loud) + math.log(sharp) ** 2 / 2 for loud, sharp in settings]
    for _ in range(4):  # what looks mistaken has less weight the next time
        weights = one_hot * (1 - mistaken)[:, None]
        found = []
        for loud, sharp in settings:
            ballots = 1 / k + loud * votes @ weights
            shares = (ballots / ballots.sum(axis=1, keepdims=True)) ** sharp
            found.append((shares / shares.sum(axis=1, keepdims=True))[np.arange(n), own])
        p = np.maximum(found, 1e-4)
        fits = np.log((1 - share) * p + share * (1 - p) / (k - 1)).sum(axis=1) - costs
        likely = np.exp(fits - fits.max())
        meant = likely / likely.sum() @ p
        wrong = share * (1 - meant) / (k - 1)
        mistaken = wrong / (wrong + (1 - share) * meant)
        mistaken[doubtful:] = 0.0
        share = (10 * MISTAKEN + float(mistaken.sum())) / (10 + doubtful)
    return together, mistaken


def _relevance(apart: Floats, one_hot: Floats) -> Floats:
    """Return how much each feature matters, by what it predicts alone; the sum is 1."""
    n, k = one_hot.shape
    own = one_hot.argmax(axis=1)
    blind = np.maximum(one_hot.sum(axis=0)[own] - 1, 0.5) / max(1, n - 1)
    gains = np.zeros(len(apart))
    for f, one in enumerate(apart):
        votes = np.exp(-ALONE * one)
        np.fill_diagonal(votes, 0.0)
        ballots = votes @ one_hot + 0.5 * one_hot.mean(axis=0)
        p = (ballots / ballots.sum(axis=1, keepdims=True))[np.arange(n), own]
        better = np.log((1 - MISTAKEN) * p + MISTAKEN / k).sum() - np.log(blind).sum()
        gains[f] = max(0.0, better - 1.0) / n  # a nat for having chosen it
    weights = gains + 0.1  # what each is taken to predict beforehand
    return np.asarray(weights / weights.sum())


def distances(values: Floats, scales: Sequence[Scale], spread: Floats) -> Floats:
    """Return how far situations are apart from one another in each feature, from 0 to 1.

    A difference d counts d / (d + spread), so that half is a usual difference and 1 an endless
    one; a feature that compares by equality counts 0 or 1. Where one value is missing the distance
    is one half, where both are, 0.

    Args:
        values, scales: see `spreads`.
        spread: shape (m,), the usual differences.

    Returns:
        shape (m, n, n).
    """
    found = np.zeros((len(scales), len(values), len(values)))
    for f, scale in enumerate(scales):
        apart = differences(values[:, f], values[:, f], scale)
        if scale.kind.is_measured:
            apart /= apart + spread[f]
        lacking = np.isnan(values[:, f])
        apart[lacking[:, None] | lacking] = 0.5
        apart[lacking[:, None] & lacking] = 0.0
        found[f] = apart
    return found
