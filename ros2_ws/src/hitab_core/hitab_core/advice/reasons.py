"""Proposals in words: what speaks for them, and what accepting them changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from hitab_core.advice.case import Case, Place, as_shown
from hitab_core.advice.proposals import Correction, Proposal, ProposalKind
from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example
from hitab_core.learning import Leaf
from hitab_core.learning.boundaries import on_circle
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_nodes import nodes
from hitab_core.transition_function import LearnedTransition
from hitab_core.wording import numbered, quantity, some

NEAREST = 3
"""How many neighbors of an example are named."""


def mistake(
    case: Case, place: Place, row: int, answers: Sequence[int] = (), *, tried: bool = True
) -> Proposal:
    """Return the proposal to remove an example that its neighbors contradict.

    Args:
        case, place: that the example is of.
        row: position of the example in ``place.own``.
        answers: indices of the corrections that it explains.
        tried: whether to learn without it and say what changes.
    """
    example, around = place.own[row], place.around
    chance = float(around.mistaken[row])
    odds = dict(zip(around.labels, around.probabilities[row].tolist(), strict=True))
    instead = max(odds.keys() - {example.next_state}, key=lambda label: (odds[label], label))
    evidence, change = [], f"{example.state} is learned again without it"
    if tried:
        before, after = case.taught(place), case.taught(place, example)
        evidence += _agreement(case, place, example, before, after)
        change = _change(case, place, before, after)
    near = place.nearest(row)[:NEAREST]
    against = [other for other in near if place.said(other) != example.next_state]
    if against:
        named = [_called(place, other) for other in against]
        similar = quantity(len(near), "most similar example")
        if len(against) < len(near):
            says = "says" if len(against) == 1 else "say"
            evidence.append(f"of the {similar}, {len(against)} {says} otherwise: {some(named)}")
        elif len(near) == 1:
            evidence.append(f"the most similar example says otherwise: {named[0]}")
        else:
            evidence.append(f"the {similar} say otherwise: {some(named)}")
        evidence.append(f"the nearest of these {_difference(case, place, row, against[0])}")
    evidence.append(
        f"{chance:.0%} likely a mistake; if it is one, {instead} was meant with "
        f"{odds[instead]:.0%}"
    )
    return _removal(case, place, example, instead, answers, chance, evidence, change)


def retraction(
    case: Case, place: Place, row: int, origin: Example, chance: float, answers: Sequence[int]
) -> Proposal:
    """Return the proposal to remove a command that was put right in the state it led to.

    Args:
        case: that the command is of.
        place: the state that it led to.
        row: position of its default example there.
        origin: its ordinary example.
        chance: probability that it is a mistake.
        answers: indices of the corrections that put it right.
    """
    accuser = place.accuser(row)
    instead = place.said(accuser)
    evidence = [
        f"you put {origin.next_state} (example {origin.number}) right afterwards, with {instead}",
        f"the situation then {_difference(case, place, row, accuser)}",
        f"{chance:.0%} likely a mistake",
    ]
    change = f"in {origin.state} the robot no longer goes to {origin.next_state} because of it"
    return _removal(case, place, origin, instead, answers, chance, evidence, change)


def _removal(
    case: Case,
    place: Place,
    example: Example,
    instead: str,
    answers: Sequence[int],
    chance: float,
    evidence: Sequence[str],
    change: str,
) -> Proposal:
    numbers = case.recorded_by(example.command) if example.command else (example.number,)
    commands = (example.command,) if example.command else ()
    return Proposal(
        ProposalKind.MISTAKE,
        example.state,
        numbers,
        commands,
        instead,
        None,
        tuple(answers),
        chance,
        tuple(evidence),
        change,
    )


def sparse(
    case: Case, place: Place, deciders: Sequence[int], index: int, chance: float
) -> Proposal:
    """Return the proposal to show more where a correction was needed.

    Args:
        case, place: that the correction is of.
        deciders: positions of the examples that the wrong decision rests on, the nearest first.
        index: of the correction.
        chance: probability that none of these is a mistake.
    """
    correction = place.corrected[index]
    where = None
    if deciders:
        row = len(place.own) + [*place.corrected].index(index)
        nearest = place.own[deciders[0]]
        where = _worth_showing(case, place, correction, nearest)
        evidence = [
            f"where you corrected it, it went to {correction.wrong} because of "
            f"{some([_called(place, d) for d in deciders])}",
            f"the nearest of these {_difference(case, place, row, deciders[0])}",
            f"{'it is' if len(deciders) == 1 else 'these are'} {chance:.0%} likely meant",
        ]
    elif correction.wrong == correction.state:
        evidence = [f"no example says when to leave {correction.state} in such a situation"]
    else:
        evidence = [f"no example says to go to {correction.wrong} there"]
    if where is None:
        change = f"the correction itself makes it go to {correction.right} there"
    else:
        shown = _values(case, where, correction.features)
        change = f"one more command where {shown} shows where to change"
    numbers = tuple(sorted(place.own[d].number for d in deciders))
    commands = sorted({place.own[d].command for d in deciders if place.own[d].command})
    return Proposal(
        ProposalKind.SPARSE,
        place.state,
        numbers,
        tuple(commands),
        correction.right,
        where,
        (index,),
        chance,
        tuple(evidence),
        change,
    )


def contradiction(group: Sequence[Example]) -> Proposal:
    """Return the question which of some examples holds; they differ only in the next state."""
    by_label: dict[str, list[int]] = {}
    for example in group:
        by_label.setdefault(example.next_state, []).append(example.number)
    said = [f"{label} ({numbered('example', n)})" for label, n in by_label.items()]
    most = max(len(n) for n in by_label.values())
    leading = [label for label, n in by_label.items() if len(n) == most]
    return Proposal(
        ProposalKind.CONTRADICTION,
        group[0].state,
        tuple(sorted(example.number for example in group)),
        tuple(sorted({example.command for example in group if example.command})),
        leading[0] if len(leading) == 1 else "",
        None,
        (),
        1.0,
        (f"in {group[0].state}, in the same situation, you commanded {' and '.join(said)}",),
        "then the robot no longer chooses at random there",
    )


def _worth_showing(
    case: Case, place: Place, correction: Correction, nearest: Example
) -> tuple[float, ...] | None:
    """Return the situation between a correction and the example that it contradicts.

    Returns:
        None if nothing needs to be shown there: numbers do not differ, booleans and categories
        alone tell the two apart, or it has been shown since.
    """
    where = halfway(correction.features, nearest.features, case.scales)
    later = [e for e in place.own if 0 < correction.since < e.number]
    if where is None or any(e.features in (where, nearest.features) for e in later):
        return None
    otherwise = tuple(
        there if scale.kind.is_measured else value
        for scale, there, value in zip(case.scales, where, nearest.features, strict=True)
    )
    function = case.taught(place)
    decided = [
        case.decides(function, replace(correction, features=values))
        for values in (where, otherwise)
    ]
    return None if decided == [correction.right, nearest.next_state] else where


def halfway(
    a: Sequence[float], b: Sequence[float], scales: Sequence[Scale]
) -> tuple[float, ...] | None:
    """Return the situation between two; None if no continuous or toroidal value differs.

    Values that compare by equality, and missing ones, are those of ``a``.
    """
    between = list(a)
    for f, scale in enumerate(scales):
        if math.isnan(a[f]) or math.isnan(b[f]):
            continue
        if scale.kind is FeatureKind.CONTINUOUS:
            between[f] = (a[f] + b[f]) / 2
        elif scale.kind is FeatureKind.TOROIDAL:
            way = on_circle(b[f] - a[f], scale.period)
            way -= scale.period if way > scale.period / 2 else 0.0
            between[f] = a[f] + way / 2
    return tuple(between) if between != list(a) else None


def _called(place: Place, row: int) -> str:
    if place.is_correction(row):
        return f"{place.said(row)} (your correction)"
    return f"{place.said(row)} (example {place.own[row].number})"


def _features(place: Place, row: int) -> tuple[float, ...]:
    if place.is_correction(row):
        return [*place.corrected.values()][row - len(place.own)].features
    return place.own[row].features


def _difference(case: Case, place: Place, row: int, other: int) -> str:
    """Return how two situations differ, in words that continue a sentence."""
    mine, its = _features(place, row), _features(place, other)
    different = [
        f"{case.names[f]} {_value(its[f], case.scales[f])} instead of "
        f"{_value(mine[f], case.scales[f])}"
        for f in range(len(mine))
        if mine[f] != its[f] and not (math.isnan(mine[f]) and math.isnan(its[f]))
    ]
    return f"had {some(different, most=3)}" if different else "was the same"


def _values(case: Case, values: Sequence[float], usual: Sequence[float]) -> str:
    shown = [
        f"{name} is {_value(value, scale)}"
        for name, value, scale, was in zip(case.names, values, case.scales, usual, strict=True)
        if value != was
    ]
    return some(shown, between=" and ")


def _value(value: float, scale: Scale) -> str:
    if math.isnan(value):
        return "missing"
    if scale.kind is FeatureKind.BOOLEAN:
        return "true" if value else "false"
    if scale.kind is FeatureKind.CATEGORICAL and 0 <= value < len(scale.categories):
        return scale.categories[int(value)]
    return f"{value:.4g}"


def _agreement(
    case: Case,
    place: Place,
    example: Example,
    before: LearnedTransition | None,
    after: LearnedTransition | None,
) -> list[str]:
    """Return that all others agree without an example, if they do and did not with it."""
    others = [*place.corrected.values(), *(as_shown(e) for e in place.own if e is not example)]
    if any(case.decides(after, at) != at.right for at in others):
        return []
    rules = [_rules(function) for function in (before, after)]
    agreed_before = all(case.decides(before, at) == at.right for at in others)
    if agreed_before and rules[1] >= rules[0]:
        return []
    shown = f"the other {quantity(len(place.own) - 1, 'example')}"
    if place.corrected:
        shown += f" and your {quantity(len(place.corrected), 'correction')}"
    if agreed_before:
        return [f"without it, fewer rules explain {shown}"]
    return [f"without it, {shown} fit together"]


def _rules(function: LearnedTransition | None) -> int:
    """Return the number of rules of a tree; 0 for another classifier."""
    if not isinstance(function, TransitionTree):
        return 0
    return sum(isinstance(node, Leaf) for node in nodes(function.root_))


def _change(
    case: Case, place: Place, before: LearnedTransition | None, after: LearnedTransition | None
) -> str:
    """Return the first difference between two functions where something was shown."""
    for at in [*place.corrected.values(), *map(as_shown, place.own)]:
        was, will = case.decides(before, at), case.decides(after, at)
        if was != will:
            shown = _values(case, at.features, [math.nan] * len(at.features))
            where = f", where {shown}," if shown else ""
            return f"in {place.state}{where} it goes to {will} instead of {was}"
    return f"{place.state} decides the same as before where you have shown something"
