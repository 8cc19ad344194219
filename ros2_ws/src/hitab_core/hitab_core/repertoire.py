"""All behaviors that can be states of an automaton: basic, hand-written and trained."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NoReturn

from hitab_core.automaton import FLAGS, RESERVED, START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Scale
from hitab_core.errors import LostBehaviorError, VocabularyError
from hitab_core.hierarchy import circle_among, in_order
from hitab_core.remedies import Do, Remedy
from hitab_core.use import Use
from hitab_core.vocabulary import unknown


class Repertoire:
    """The behaviors of a domain plus the trained ones.

    A trained automaton replaces a hand-written one of the same name, but not a basic behavior.
    Nothing replaces a lost behavior, see `hitab_core.library.contents.Losses`.

    Attributes:
        domain: of the robot.
        lost: why behaviors cannot be used, by name. If the library cannot be read, any unknown
            one may be among them.
    """

    def __init__(
        self,
        domain: Domain,
        trained: Mapping[str, Automaton] | None = None,
        lost: Mapping[str, str] | None = None,
        unread: str = "",
    ) -> None:
        self.domain = domain
        self.lost = dict(lost or {})
        self._unread = unread
        self._automata: dict[str, Automaton] = {}
        # Kept up to date so that checking a use is cheap.
        self._parameters = {
            name: b.parameters for name, b in domain.behaviors.items() if name not in self.lost
        }
        self._users: dict[str, set[str]] = {}
        for automaton in domain.automata.values():
            if automaton.name not in self.lost:
                self._put(automaton)
        for automaton in (trained or {}).values():
            self.check_name(automaton.name)
            self._put(automaton)
        circle = circle_among(self._automata, self._used)
        if circle:
            _refuse(circle)
        for automaton in self._automata.values():
            self._check_uses(automaton)

    @property
    def automata(self) -> Mapping[str, Automaton]:
        """The automata, hand-written and trained, by name."""
        return self._automata

    @property
    def vacancies(self) -> tuple[str, ...]:
        """What is missing because it was taken out of the domain and not trained since.

        One text per behavior, with what it is needed for. A trained behavior that is lost leaves
        no vacancy, but takes along what is made of it; see `lost`.
        """
        return tuple(
            f'"{name}" was taken out, and nothing is done in its place{self._need(name)}'
            for name in self._vacant
        )

    @property
    def remedies(self) -> tuple[Remedy, ...]:
        """What a person can do about the vacancies."""
        trained = [Do.TRAIN(behavior=name) for name in self._vacant]
        return (*trained, Do.IMPORT()) if trained else ()

    @property
    def _vacant(self) -> list[str]:
        out, automata = sorted(self.domain.taken_out), self.domain.automata
        return [name for name in out if self._automata.get(name) is automata[name]]

    def _need(self, name: str) -> str:
        users = in_order([name], lambda used: self._users.get(used, ()))[:-1]
        return f"; it is needed for {', '.join(sorted(users))}" if users else ""

    def __contains__(self, name: object) -> bool:
        return name in self._parameters

    def names(self) -> list[str]:
        """Return the names of all behaviors, sorted."""
        return sorted(self._parameters)

    def get(self, name: str) -> BasicBehavior | Automaton:
        """Return the behavior called ``name``.

        Raises:
            LostBehaviorError: if it is lost.
            VocabularyError: if there is none.
        """
        self._refuse_lost(name)
        found = self._automata.get(name) or self.domain.behaviors.get(name)
        if found is None:
            raise VocabularyError(unknown("behavior", name, self.names()))
        return found

    def add(self, automaton: Automaton) -> None:
        """Add a trained automaton, replacing an earlier one of the same name.

        Raises:
            VocabularyError: if it uses something that does not exist, or itself, even indirectly.
        """
        self.check_new(automaton)
        before = self._automata.get(automaton.name)
        self._put(automaton)
        try:
            # Its users depend on its parameters only.
            for name in sorted(self._users.get(automaton.name, ())):
                self._check_uses(self._automata[name])
        except VocabularyError:
            if before is None:
                self._remove(automaton.name)
            else:
                self._put(before)
            raise

    def discard(self, name: str) -> None:
        """Remove a trained automaton; a hand-written one of that name takes its place again."""
        if name in self._automata:
            self._remove(name)
        if name in self.domain.automata:
            self._put(self.domain.automata[name])

    def _refuse_lost(self, name: str) -> None:
        if name in self.lost:
            raise LostBehaviorError(self.lost[name], Do.CHECK_LIBRARY())
        if self._unread and name not in self._parameters:
            raise LostBehaviorError(f'"{name}" is unknown, and {self._unread}', Do.CHECK_LIBRARY())

    def _put(self, automaton: Automaton) -> None:
        before = self._automata.get(automaton.name)
        for used in () if before is None else before.behaviors_used:
            self._users[used].discard(automaton.name)
        self._automata[automaton.name] = automaton
        self._parameters[automaton.name] = automaton.parameters
        for used in automaton.behaviors_used:
            self._users.setdefault(used, set()).add(automaton.name)

    def _remove(self, name: str) -> None:
        for used in self._automata.pop(name).behaviors_used:
            self._users[used].discard(name)
        basic = self.domain.behaviors.get(name)
        if basic is None:
            del self._parameters[name]
        else:
            self._parameters[name] = basic.parameters

    def parameters_of(self, name: str) -> tuple[str, ...]:
        """Return the parameters of the behavior called ``name``."""
        return self.get(name).parameters

    def is_one_shot(self, use: Use) -> bool:
        """Whether a state is executed only once per entry and so gets no default example."""
        if use.name in FLAGS:
            return True
        behavior = self.get(use.name)
        return isinstance(behavior, BasicBehavior) and behavior.one_shot

    def stands_still(self, use: Use) -> bool:
        """Whether a state never moves the robot."""
        behavior = self.domain.behaviors.get(use.name)
        return behavior is not None and behavior.stands_still

    def scale_of(self, feature: Use) -> Scale:
        """Return how the values of a feature compare."""
        return self.domain.feature(feature.name).scale

    def check_state(self, use: Use, parameters: tuple[str, ...] = ()) -> None:
        """Check that ``use`` can be a state of an automaton with these parameters.

        Raises:
            VocabularyError: naming what is unknown or wrongly bound.
        """
        if use.name in RESERVED:
            if use.name == START:
                raise VocabularyError(f"{START} cannot be commanded; every automaton begins there")
            if use.arguments:
                raise VocabularyError(f'flag state "{use.name}" takes no targets')
            return
        self._refuse_lost(use.name)
        self.domain.check_use(use, self._parameters, parameters, what="behavior")

    def check_feature(self, use: Use, parameters: tuple[str, ...] = ()) -> None:
        """Check that ``use`` can be a feature of an automaton with these parameters.

        Raises:
            VocabularyError: naming what is unknown or wrongly bound.
        """
        self.domain.check_feature(use, parameters)

    def check_new(self, automaton: Automaton) -> None:
        """Check an automaton, including its name, before training it.

        Raises:
            VocabularyError: naming what is wrong.
        """
        self.check_name(automaton.name)
        self.check(automaton)

    def check(self, automaton: Automaton) -> None:
        """Check that everything ``automaton`` uses exists and that it is not recursive.

        Raises:
            VocabularyError: naming the automaton and what is wrong.
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
                self.check_feature(feature, automaton.parameters)
        except VocabularyError as error:
            raise VocabularyError(f'automaton "{automaton.name}": {error}') from None

    def _used(self, name: str) -> Iterable[str]:
        automaton = self._automata.get(name)
        return () if automaton is None else automaton.behaviors_used

    def check_name(self, name: str) -> None:
        """Check that a trained automaton can have this name.

        Raises:
            VocabularyError: if it is reserved, or that of a basic behavior.
        """
        if name in RESERVED:
            raise VocabularyError(f'"{name}" is reserved; choose another name')
        if name in self.domain.behaviors:
            raise VocabularyError(
                f'"{name}" is a basic behavior of domain "{self.domain.name}"; '
                "choose another name for the automaton"
            )

    def needed_by(self, name: str) -> list[str]:
        """Return the automata that ``name`` is made of, dependencies first, itself last."""
        self.get(name)
        return [made for made in in_order([name], self._used) if made in self._automata]


def _refuse(circle: Sequence[str]) -> NoReturn:
    raise VocabularyError(
        f"recursive automaton: {' -> '.join(circle)}; a behavior cannot use itself"
    )
