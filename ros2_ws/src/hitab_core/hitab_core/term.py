"""A behavior or feature with its arguments, as an automaton uses it.

It is written ``DistanceTo(ball)``, or without parameters just ``Stop``. An argument names a target
of the domain or a parameter of the automaton that contains the term.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.wording import natural, quantity

VOCABULARY_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,99}\Z")
"""Pattern of the names of behaviors, targets and parameters; behaviors also name files."""

VOCABULARY_NAME_RULE = "use up to 100 letters, digits and _, beginning with a letter"
_TERM = re.compile(r"\s*([A-Za-z][A-Za-z0-9_]*)\s*(?:\(([^()]*)\))?\s*\Z")


@dataclass(frozen=True, slots=True, order=True)
class Term:
    """A behavior or feature with its arguments, in the order of its parameters."""

    name: str
    arguments: tuple[str, ...] = ()

    @classmethod
    def parse(cls, text: str, more: Iterable[str] = ()) -> Term:
        """Read ``Name`` or ``Name(argument, ...)``; an argument may be a number, ``name=value``.

        Args:
            text: the text.
            more: further arguments, after those in the text.

        Raises:
            VocabularyError: if the text has another form.

        Examples:
            >>> Term.parse("PassTo( mate )")
            Term(name='PassTo', arguments=('mate',))
        """
        match = _TERM.match(text)
        if match is None:
            raise VocabularyError(
                f'"{text}" is not a use of a behavior or feature; write Name or Name(target)'
            )
        inner = match.group(2)
        arguments = tuple(part.strip() for part in inner.split(",")) if inner else ()
        for argument in arguments:
            if VOCABULARY_NAME.match(argument.partition("=")[0].rstrip()) is None:
                raise VocabularyError(f'"{argument}" in "{text}" is not a target or parameter')
        return cls(match.group(1), (*arguments, *more))

    def bound(self, parameters: Mapping[str, str]) -> Term:
        """Return this term with each automaton parameter replaced by its binding.

        Examples:
            >>> str(Term("GoTo", ("A",)).bound({"A": "ball"}))
            'GoTo(ball)'
        """
        if not self.arguments:
            return self
        return Term(self.name, tuple(parameters.get(a, a) for a in self.arguments))

    def __str__(self) -> str:
        """Return the text that :meth:`parse` reads."""
        return f"{self.name}({', '.join(self.arguments)})" if self.arguments else self.name


def wrong_number(what: str, term: Term, expected: Sequence[str], things: Iterable[str]) -> str:
    """Return an error about a term with too many or too few targets, and one that is right.

    Args:
        what: kind of the term, such as "feature".
        term: term with the wrong number of arguments.
        expected: parameters of the behavior or feature.
        things: targets, and parameters of the automaton that contains the term.

    Examples:
        >>> print(wrong_number("feature", Term("DistanceTo"), ["X"], ["goal", "ball"]))
        feature "DistanceTo" takes 1 target, not 0; write, for example, DistanceTo(ball)
    """
    number = len(term.arguments)
    if not expected:
        return f'{what} "{term.name}" takes no targets, not {number}; write {term.name}'
    takes = f'{what} "{term.name}" takes {quantity(len(expected), "target")}, not {number}'
    known = sorted(things, key=natural)
    if not known:
        return f"{takes}; this domain has no targets"
    given = [argument for argument in term.arguments if argument in known][: len(expected)]
    others = [thing for thing in known if thing not in given] or known
    more = (others[i % len(others)] for i in range(len(expected) - len(given)))
    return f"{takes}; write, for example, {Term(term.name, (*given, *more))}"
