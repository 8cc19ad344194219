"""Renaming a behavior, also in the behaviors that are made of it: one change of the library."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.learning.transition_learning import relearned, rules_of
from hitab_core.library.behavior_file import BehaviorFile
from hitab_core.library.change import LibraryChange
from hitab_core.term import VOCABULARY_NAME, VOCABULARY_NAME_RULE, Term
from hitab_core.texts.errors import LibraryError
from hitab_core.texts.vocabulary import has


def plan_renaming(
    change: LibraryChange, domain: Domain, old: str, new: str, *, with_users: bool = False
) -> tuple[list[str], list[str]]:
    """Plan to rename a behavior, and to rename it in the behaviors that use it.

    Args:
        change: the change of the library.
        domain: domain in which the behaviors were trained.
        old: the present name.
        new: the next name.
        with_users: change the behaviors that use it, too.

    Returns:
        The behaviors that use it, and the ones among them whose decisions change: of two equally
        good decisions, the names of the behaviors may determine which is taken.

    Raises:
        LibraryError: if there is no such behavior, the new name is taken, something in the library
            is lost, or others use it and ``with_users`` is not set.
    """
    files = change.before.readable
    if change.losses:
        raise LibraryError(
            f'"{old}" cannot be renamed yet, since files that may use it cannot be read: '
            f"{'; '.join(change.losses.faults)}",
            *change.losses.ways_out,
        )
    if old not in files:
        raise LibraryError(f'there is no behavior "{old}" {has(files, old)}')
    if VOCABULARY_NAME.match(new) is None:
        raise LibraryError(f'"{old}" cannot be called "{new}"; {VOCABULARY_NAME_RULE}')
    if new in files or new in domain.behaviors or new in domain.automata:
        raise LibraryError(f'"{old}" cannot be called "{new}": that name is taken; choose another')
    users = change.before.users(old)
    if users and not with_users:
        raise LibraryError(
            f'"{old}" is used by {", ".join(users)}; give --with-users to rename it there, too'
        )
    otherwise = []
    for name in (old, *users):
        file = files[name]
        renamed = _renamed(file, domain, old, new)
        provenance = replace(file.provenance, note=f'"{old}" renamed to "{new}"')
        labels = dict(zip(file.automaton.labels, renamed.labels, strict=True))
        expectations = [
            replace(
                one,
                state=labels.get(one.state, one.state),
                next_state=labels.get(one.next_state, one.next_state),
            )
            for one in file.expectations
        ]
        saved = change.save(renamed, file.classifier, provenance, expectations=expectations)
        if _rules(saved) != _rules(file, old, new):
            otherwise.append(saved.name)
    change.remove(old)
    return users, otherwise


def _renamed(file: BehaviorFile, domain: Domain, old: str, new: str) -> Automaton:
    automaton = file.automaton

    def term(state: Term) -> Term:
        return Term(new, state.arguments) if state.name == old else state

    labels = {str(state): str(term(state)) for state in automaton.states}
    examples = tuple(
        replace(
            example,
            state=labels.get(example.state, example.state),
            next_state=labels.get(example.next_state, example.next_state),
        )
        for example in automaton.examples
    )
    renamed = replace(
        automaton,
        name=new if automaton.name == old else automaton.name,
        states=tuple(term(state) for state in automaton.states),
        examples=examples,
        transitions={},
    )
    return relearned(renamed, domain, file.classifier)


def _rules(file: BehaviorFile, old: str = "", new: str = "") -> Counter[tuple[Any, ...]]:
    """Return an automaton's trees with another name for one of its states."""

    def label(text: str) -> str:
        return new + text.removeprefix(old) if text.partition("(")[0] == old else text

    return Counter(
        (
            label(state),
            rule.conditions,
            frozenset((label(to), p) for to, p in rule.distribution.items()),
        )
        for state, rules in rules_of(file.automaton).items()
        for rule in rules
    )
