"""All behaviors that can be states of an automaton: basic, hand-written and trained."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NoReturn

from hitab_core.automaton import FLAGS, RESERVED_NAMES, START, Automaton
from hitab_core.domain import BasicBehavior, Domain
from hitab_core.hierarchy import circle_among, in_order
from hitab_core.number import numbers_of, without_numbers
from hitab_core.term import Term
from hitab_core.texts.errors import LostBehaviorError, VocabularyError
from hitab_core.texts.remedies import Fix, Remedy
from hitab_core.texts.vocabulary import unknown


class Repertoire:
    """The behaviors of a domain plus the trained ones.

    A trained automaton replaces a hand-written one of the same name, but not a basic behavior.
    Nothing replaces a lost behavior, see `hitab_core.library.contents.LostBehaviors`.

    Attributes:
        domain: domain of the robot.
        automata: hand-written and trained, by name.
        lost: why behaviors cannot be used, by name. If the library cannot be read, any unknown
            one may be among them.
    """

    def __init__(
        self,
        domain: Domain,
        trained: Mapping[str, Automaton] | None = None,
        lost: Mapping[str, str] | None = None,
        unread: str = "",
        ways_out: Mapping[str, tuple[Remedy, ...]] | None = None,
    ) -> None:
        self.domain = domain
        self.lost = dict(lost or {})
        self._unread = unread
        self._ways_out = ways_out or {}
        self.automata: dict[str, Automaton] = {}
        for automaton in domain.automata.values():
            if automaton.name not in self.lost:
                self.automata[automaton.name] = automaton
        for automaton in (trained or {}).values():
            self.check_name(automaton.name)
            self.automata[automaton.name] = automaton
        behaviors: dict[str, BasicBehavior | Automaton] = {
            name: b for name, b in domain.behaviors.items() if name not in self.lost
        }
        behaviors |= self.automata
        self._parameters = {name: behavior.parameters for name, behavior in behaviors.items()}
        circle = circle_among(self.automata, self._used)
        if circle:
            _refuse(circle)
        for automaton in self.automata.values():
            self._check_uses(automaton)

    def __contains__(self, name: object) -> bool:
        return name in self._parameters

    def names(self) -> list[str]:
        """Return the names of all behaviors, sorted."""
        return sorted(self._parameters)

    def description_of(self, name: str) -> str:
        """Return the description of a trained behavior; empty if there is none of this name."""
        known = self.automata.get(name)
        return known.description if known is not None and known.examples else ""

    def get(self, name: str) -> BasicBehavior | Automaton:
        """Return the behavior called ``name``.

        Raises:
            LostBehaviorError: if it is lost.
            VocabularyError: if there is none.
        """
        self._refuse_lost(name)
        found = self.automata.get(name) or self.domain.behaviors.get(name)
        if found is None:
            raise VocabularyError(unknown("behavior", name, self.names()))
        return found

    def _refuse_lost(self, name: str) -> None:
        if name in self.lost:
            ways_out = self._ways_out.get(name) or (Fix.CHECK_LIBRARY(),)
            raise LostBehaviorError(self.lost[name], *ways_out)
        if self._unread and name not in self._parameters:
            raise LostBehaviorError(
                f'"{name}" is unknown, and {self._unread}', Fix.CHECK_LIBRARY()
            )

    def is_one_shot(self, term: Term) -> bool:
        """Whether a state is executed only once per entry and so gets no default example."""
        if term.name in FLAGS:
            return True
        behavior = self.get(term.name)
        return isinstance(behavior, BasicBehavior) and behavior.one_shot

    def stands_still(self, term: Term) -> bool:
        """Whether a state never moves the robot."""
        behavior = self.domain.behaviors.get(term.name)
        return behavior is not None and behavior.stands_still

    def check_state(self, term: Term, parameters: tuple[str, ...] = ()) -> None:
        """Check that ``term`` can be a state of an automaton with these parameters.

        Raises:
            VocabularyError: naming the unknown or wrongly bound word.
        """
        if term.name in RESERVED_NAMES:
            if term.name == START:
                raise VocabularyError(f"{START} cannot be commanded; every automaton begins there")
            if term.arguments:
                raise VocabularyError(f'flag state "{term.name}" takes no targets')
            return
        self._refuse_lost(term.name)
        if (targets := without_numbers(term)) != term:
            numbers_of(term, self.domain.numbers_of(term))
        self.domain.check_use(targets, self._parameters, parameters, what="behavior")

    def commanded(self, term: Term) -> tuple[Term, tuple[float, ...]]:
        """Return the behavior to perform, with its targets alone, and its numbers.

        Raises:
            VocabularyError: if a number is unknown, missing, or not within its bounds.
        """
        return without_numbers(term), numbers_of(term, self.domain.numbers_of(term))

    def check_performable(self, term: Term) -> None:
        """Check that a behavior can be the top-level one.

        Raises:
            VocabularyError: if there is no such behavior or target.
        """
        self.get(term.name)
        self.check_state(term)
        self.commanded(term)

    def check(self, automaton: Automaton) -> None:
        """Check that ``automaton`` is not recursive, and that all its parts exist.

        Raises:
            VocabularyError: naming the automaton and its fault.
        """
        # Recursion first: a new automaton in its own states would also be "unknown".
        circle = circle_among(
            [automaton.name],
            lambda name: automaton.behaviors_used if name == automaton.name else self._used(name),
        )
        if circle:
            _refuse(circle)
        self._check_uses(automaton)

    def _check_uses(self, automaton: Automaton) -> None:
        for parameter in automaton.parameters:
            if parameter in self.domain.targets:
                raise VocabularyError(
                    f'automaton "{automaton.name}": parameter "{parameter}" is also a target; '
                    "rename it"
                )
        try:
            for state in automaton.states:
                self.check_state(state, automaton.parameters)
            for feature in automaton.features:
                self.domain.check_feature(feature, automaton.parameters)
        except VocabularyError as error:
            raise VocabularyError(f'automaton "{automaton.name}": {error}') from None

    def _used(self, name: str) -> Iterable[str]:
        automaton = self.automata.get(name)
        return () if automaton is None else automaton.behaviors_used

    def check_name(self, name: str) -> None:
        """Check that a trained automaton can have this name.

        Raises:
            VocabularyError: if it is reserved, or a basic behavior has it.
        """
        if name in RESERVED_NAMES:
            raise VocabularyError(f'"{name}" is reserved; choose another name')
        if name in self.domain.behaviors:
            raise VocabularyError(
                f'"{name}" is a basic behavior of domain "{self.domain.name}"; '
                "choose another name for the automaton"
            )

    def needed_by(self, name: str) -> list[str]:
        """Return the automata that ``name`` is made of, dependencies first, itself last."""
        self.get(name)
        return [made for made in in_order([name], self._used) if made in self.automata]


def _refuse(circle: Sequence[str]) -> NoReturn:
    raise VocabularyError(
        f"recursive automaton: {' -> '.join(circle)}; a behavior cannot use itself"
    )
