"""Prepares an automaton for saving: trims unneeded parts and binds its targets.

Source: the paper, section 3, "Running HiTAB": before a behavior is saved, unused states and
features are trimmed, and parameters bound to a target or to a parameter of the automaton itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from hitab_core.automaton import FLAGS, OWN_FEATURES, START, Automaton
from hitab_core.domain import Domain
from hitab_core.learning.transition_learning import relearned
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_nodes import described, nodes
from hitab_core.repertoire import Repertoire
from hitab_core.term import VOCABULARY_NAME, VOCABULARY_NAME_RULE, Term
from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.vocabulary import has
from hitab_core.transition_function import TransitionFunction


def trim(
    automaton: Automaton, repertoire: Repertoire, *, classifier: str = "tree"
) -> tuple[Automaton, list[str]]:
    """Return an automaton without unneeded states and features.

    A state is needed if an example mentions it, a feature if a transition function can look at it
    or if the behavior requires it in every state.
    The trimmed automaton decides exactly as before, and notes the features chosen, so that its
    training can be resumed with them. A C4.5 tree depends a little even on unused
    features: one that would change a decision if left out is kept.

    Args:
        automaton: the trained automaton.
        repertoire: the available behaviors and features.
        classifier: classifier that learned it.

    Returns:
        The trimmed automaton and readable notes on the trimmed states and features.

    Raises:
        VocabularyError: if something is bound to neither a target nor a parameter.
        FeatureValueError, TrainingError: see `learn_transitions`.
    """
    check_bound(automaton, repertoire.domain)
    mentioned = {label for e in automaton.examples for label in (e.state, e.next_state)}
    states = tuple(s for s in automaton.states if str(s) in mentioned)
    notes = [
        f'state "{state}" was never visited' for state in automaton.states if state not in states
    ]
    complete = relearned(
        replace(automaton, states=states, transitions={}), repertoire.domain, classifier
    )
    columns = _needed_columns(complete, repertoire.domain, classifier)
    trimmed = relearned(_with_columns(complete, columns), repertoire.domain, classifier)
    used = _columns_used(complete, repertoire.domain)
    for i, feature in enumerate(automaton.features):
        if i not in columns:
            notes.append(f'feature "{feature}" is not used by any transition function')
        elif i not in used:
            notes.append(
                f'kept feature "{feature}": no transition function uses it, but without it the '
                "learned functions would differ"
            )
    if len(columns) < len(automaton.features):
        trimmed = replace(trimmed, chosen=automaton.features)
    mentioned = {a for term in (*trimmed.states, *trimmed.features) for a in term.arguments}
    notes += [
        f'kept parameter "{parameter}", which nothing uses'
        for parameter in automaton.parameters
        if parameter not in mentioned
    ]
    return trimmed, notes


def rebind(
    automaton: Automaton,
    bindings: Mapping[str, str],
    repertoire: Repertoire,
    *,
    classifier: str = "tree",
) -> Automaton:
    """Return the same automaton for other targets.

    ``{"ball": "A"}`` generalizes a behavior for the ball: ``A`` becomes a parameter.
    ``{"A": "ball"}`` binds the parameter ``A`` to the ball, which removes the parameter. A whole
    use, such as ``{"DistanceTo(ball)": "DistanceTo(A)"}``, applies to that use alone and takes
    precedence.

    Args:
        automaton: the automaton; its states, features and examples are bound.
        bindings: targets, parameters or whole uses, and their replacements.
        repertoire: the available behaviors, features and targets.
        classifier: classifier that learned it.

    Raises:
        VocabularyError: if a binding replaces something unknown, or two states or two features
            would become the same.
    """
    targets = repertoire.domain.targets
    terms = (*automaton.states, *automaton.features)
    there = {a for term in terms for a in term.arguments} | {str(term) for term in terms}
    there |= {*automaton.parameters}
    for old, new in bindings.items():
        if old not in there:
            raise VocabularyError(
                f'"{old}" is not in automaton "{automaton.name}" {has(there, old)}'
            )
        if "(" not in old and VOCABULARY_NAME.match(new) is None:
            raise VocabularyError(
                f'"{new}" cannot be a target or parameter; {VOCABULARY_NAME_RULE}'
            )

    def bound(term: Term) -> Term:
        whole = bindings.get(str(term)) if term.arguments else None
        if whole is None:
            return term.bound(bindings)
        new = Term.parse(whole)
        if new.name != term.name:
            raise VocabularyError(f'"{term}" cannot become "{new}": only its targets can be bound')
        return new

    def label(old: str) -> str:
        return old if old in (START, *FLAGS) else str(bound(Term.parse(old)))

    states = _distinct(automaton.states, bound, "state")
    features = _distinct(automaton.features, bound, "feature")
    mentioned = [a for term in (*states, *features) for a in term.arguments]
    parameters = [p for p in automaton.parameters if p in mentioned or p not in bindings]
    parameters += [a for a in mentioned if a not in targets and a in bindings.values()]
    parameters += [a for a in _arguments(bindings) if a in mentioned and a not in targets]
    # Two readings that become the same were of the same target.
    read = {bound(term): i for i, term in reversed([*enumerate(automaton.readable)])}
    kept = sorted(read.values())
    rebound = Automaton(
        automaton.name,
        states,
        features,
        {},
        tuple(dict.fromkeys(parameters)),
        tuple(
            replace(
                e,
                state=label(e.state),
                next_state=label(e.next_state),
                readings=tuple(e.readings[i] for i in kept) if e.readings else (),
            )
            for e in automaton.examples
        ),
        automaton.description,
        tuple(bound(automaton.readable[i]) for i in kept),
    )
    repertoire.check(rebound)
    return relearned(rebound, repertoire.domain, classifier)


def check_bound(automaton: Automaton, domain: Domain) -> None:
    """Check that every argument is bound.

    Raises:
        VocabularyError: naming each argument that is neither a target nor a parameter.
    """
    there = [*domain.targets, *automaton.parameters]
    features = [term for term in automaton.features if term not in OWN_FEATURES]
    for term in (*automaton.states, *features):
        for argument in term.arguments:
            if argument not in there:
                raise VocabularyError(
                    f'"{argument}" in "{term}" of automaton "{automaton.name}" is unbound; bind '
                    f"it to a target, or make it a parameter {has(there, argument)}"
                )


def _arguments(bindings: Mapping[str, str]) -> list[str]:
    """Return the arguments of the whole uses in bindings."""
    return [a for old, new in bindings.items() if "(" in old for a in Term.parse(new).arguments]


def _distinct(terms: Sequence[Term], bound: Any, what: str) -> tuple[Term, ...]:
    became: dict[Term, Term] = {}
    for term in terms:
        new = bound(term)
        if new in became:
            raise VocabularyError(
                f'{what}s "{became[new]}" and "{term}" would both become "{new}"; '
                "bind one of them to something else"
            )
        became[new] = term
    return tuple(became)


def _columns_used(automaton: Automaton, domain: Domain) -> set[int]:
    if automaton.numbers:  # a moment is near in all features
        return {*range(len(automaton.features))}
    required = {
        i for i, term in enumerate(automaton.features) if domain.feature(term.name).required
    }
    return required.union(*(one.features_used for one in automaton.transitions.values()))


def _with_columns(automaton: Automaton, columns: Sequence[int]) -> Automaton:
    return replace(
        automaton,
        features=tuple(automaton.features[i] for i in columns),
        examples=tuple(e.with_columns(columns) for e in automaton.examples),
        transitions={},
    )


def _needed_columns(complete: Automaton, domain: Domain, classifier: str) -> list[int]:
    """Return the indices of the features that affect the transition functions."""

    def suffice(columns: Sequence[int]) -> bool:
        fewer = relearned(_with_columns(complete, columns), domain, classifier)
        return all(
            _decide_alike(function, fewer.transitions[state], columns)
            for state, function in complete.transitions.items()
        )

    everything = range(len(complete.features))
    used = _columns_used(complete, domain)
    needed = [i for i in everything if i in used]
    if suffice(needed):
        return needed
    needed = list(everything)
    for i in everything:
        fewer = [other for other in needed if other != i]
        if i not in used and suffice(fewer):
            needed = fewer
    return needed


def _decide_alike(
    before: TransitionFunction, after: TransitionFunction, columns: Sequence[int]
) -> bool:
    """Return whether two functions decide alike when ``after`` sees only some features."""
    if isinstance(before, TransitionTree) and isinstance(after, TransitionTree):
        return before.labels == after.labels and _nodes(before) == _nodes(after, columns)
    # Other classifiers use all features, or none if there is nothing to decide.
    return len(columns) == len(before.features_used) or before.features_used == ()


def _nodes(tree: TransitionTree, columns: Sequence[int] | None = None) -> list[dict[str, Any]]:
    plain: list[dict[str, Any]] = [
        {**described(node), "branches": len(node.branches)} for node in nodes(tree.root_)
    ]
    for node in plain:
        if columns is not None and "feature" in node:
            node["feature"] = columns[node["feature"]]
    return plain
