"""All behaviors that can be a state of an automaton: basic, hand-written and trained ones."""

from __future__ import annotations

from collections.abc import Mapping

from hitab_core.automaton import FLAGS, RESERVED, START, Automaton
from hitab_core.domain import BOOLEAN_SCALE, BasicBehavior, Domain, Scale
from hitab_core.errors import VocabularyError, has
from hitab_core.use import Use


class Repertoire:
    """The behaviors of a domain with the trained ones beside and in place of its automata.

    A trained automaton replaces a hand-written one of the same name; it cannot replace a basic
    behavior.
    """

    def __init__(self, domain: Domain, trained: Mapping[str, Automaton] | None = None) -> None:
        self.domain = domain
        self._automata: dict[str, Automaton] = dict(domain.automata)
        for automaton in (trained or {}).values():
            self._refuse_name(automaton.name)
            self._automata[automaton.name] = automaton
        for automaton in self._automata.values():
            self.check(automaton)

    @property
    def automata(self) -> Mapping[str, Automaton]:
        """The automata, hand-written and trained, by name."""
        return self._automata

    def __contains__(self, name: object) -> bool:
        return name in self._automata or name in self.domain.behaviors

    def names(self) -> list[str]:
        """Return the names of all behaviors, sorted."""
        return sorted({*self._automata, *self.domain.behaviors})

    def get(self, name: str) -> BasicBehavior | Automaton:
        """Return the behavior called ``name``.

        Raises:
            VocabularyError: if there is none.
        """
        found = self._automata.get(name) or self.domain.behaviors.get(name)
        if found is None:
            raise VocabularyError(f'unknown behavior "{name}" {has(self.names())}')
        return found

    def add(self, automaton: Automaton) -> None:
        """Add a trained automaton, or put it in the place of an earlier one of its name.

        Raises:
            VocabularyError: if it uses what does not exist, or itself, directly or through others.
        """
        self._refuse_name(automaton.name)
        before = self._automata.get(automaton.name)
        self._automata[automaton.name] = automaton
        try:
            for affected in self._automata.values():
                self.check(affected)
        except VocabularyError:
            if before is None:
                del self._automata[automaton.name]
            else:
                self._automata[automaton.name] = before
            raise

    def discard(self, name: str) -> None:
        """Remove a trained automaton; a hand-written one of that name takes its place again."""
        self._automata.pop(name, None)
        if name in self.domain.automata:
            self._automata[name] = self.domain.automata[name]

    def parameters_of(self, name: str) -> tuple[str, ...]:
        """Return the parameters of the behavior called ``name``."""
        return self.get(name).parameters

    def is_one_shot(self, use: Use) -> bool:
        """Whether a state is executed exactly once, so that it gets no default example."""
        if use.name in FLAGS:
            return True
        behavior = self.get(use.name)
        return isinstance(behavior, BasicBehavior) and behavior.one_shot

    def scale_of(self, feature: Use) -> Scale:
        """Return how the values of a feature compare; flags are boolean."""
        if feature.name in FLAGS:
            return BOOLEAN_SCALE
        return self.domain.features[feature.name].scale

    def check_state(self, use: Use, parameters: tuple[str, ...] = ()) -> None:
        """Check that ``use`` can be a state of an automaton with these parameters.

        Raises:
            VocabularyError: naming what is unknown or bound wrongly.
        """
        if use.name in RESERVED:
            if use.name == START:
                raise VocabularyError(f"{START} cannot be commanded; it is where automata begin")
            if use.arguments:
                raise VocabularyError(f'flag state "{use.name}" takes no targets')
            return
        known = {name: self.parameters_of(name) for name in self.names()}
        self.domain.check_use(use, known, parameters, what="behavior")

    def check_feature(self, use: Use, parameters: tuple[str, ...] = ()) -> None:
        """Check that ``use`` can be a feature of an automaton with these parameters.

        Raises:
            VocabularyError: naming what is unknown or bound wrongly.
        """
        if use.name in FLAGS and not use.arguments:
            return
        known = {f.name: f.parameters for f in self.domain.features.values()}
        known |= dict.fromkeys(FLAGS, ())
        self.domain.check_use(use, known, parameters, what="feature")

    def check_new(self, automaton: Automaton) -> None:
        """Check an automaton that is about to be trained, its name included.

        Raises:
            VocabularyError: naming what is wrong.
        """
        self._refuse_name(automaton.name)
        self.check(automaton)

    def check(self, automaton: Automaton) -> None:
        """Check that everything that ``automaton`` uses exists and that it is not recursive.

        Raises:
            VocabularyError: naming the automaton and what is wrong.
        """
        for parameter in automaton.parameters:
            if parameter in self.domain.targets:
                raise VocabularyError(
                    f'automaton "{automaton.name}": parameter "{parameter}" is also a target; '
                    "call it something else"
                )
        # Recursion first: an automaton in its own states is also "unknown" while it is new.
        self._refuse_recursion(automaton, ())
        try:
            for state in automaton.states:
                self.check_state(state, automaton.parameters)
            for feature in automaton.features:
                self.check_feature(feature, automaton.parameters)
        except VocabularyError as error:
            raise VocabularyError(f'automaton "{automaton.name}": {error}') from None

    def _refuse_recursion(self, automaton: Automaton, above: tuple[str, ...]) -> None:
        if automaton.name in above:
            circle = " -> ".join((*above[above.index(automaton.name) :], automaton.name))
            raise VocabularyError(f"recursive automaton: {circle}; a behavior cannot use itself")
        for name in sorted(automaton.behaviors_used):
            child = automaton if name == automaton.name else self._automata.get(name)
            if child is not None:
                self._refuse_recursion(child, (*above, automaton.name))

    def _refuse_name(self, name: str) -> None:
        if name in RESERVED:
            raise VocabularyError(f'"{name}" is reserved; choose another name')
        if name in self.domain.behaviors:
            raise VocabularyError(
                f'"{name}" is a basic behavior of domain "{self.domain.name}"; '
                "choose another name for the automaton"
            )

    def needed_by(self, name: str) -> list[str]:
        """Return the automata that ``name`` is made of, itself last, each after what it uses."""
        order: list[str] = []

        def visit(visited: str) -> None:
            automaton = self._automata.get(visited)
            if automaton is None or visited in order:
                return
            for used in sorted(automaton.behaviors_used):
                visit(used)
            order.append(visited)

        self.get(name)
        visit(name)
        return order
