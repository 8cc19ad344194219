"""The use of a behavior or feature in an automaton: its name and what it is bound to.

It is written ``DistanceTo(ball)``, or without parameters just ``Stop``. An argument names a target
of the domain or a parameter of the automaton that contains the use.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from hitab_core.errors import VocabularyError

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,99}\Z")
"""Pattern of the names of behaviors, targets and parameters; behaviors also name files."""

NAME_RULE = "use up to 100 letters, digits and _"
_USE = re.compile(r"\s*([A-Za-z][A-Za-z0-9_]*)\s*(?:\(([^()]*)\))?\s*\Z")


@dataclass(frozen=True, slots=True, order=True)
class Use:
    """A behavior or feature with its arguments, in the order of its parameters."""

    name: str
    arguments: tuple[str, ...] = ()

    @classmethod
    def parse(cls, text: str) -> Use:
        """Read ``Name`` or ``Name(argument, ...)``.

        Raises:
            VocabularyError: if the text has another form.

        Example:
            >>> Use.parse("PassTo( mate )")
            Use(name='PassTo', arguments=('mate',))
        """
        match = _USE.match(text)
        if match is None:
            raise VocabularyError(
                f'"{text}" is not a use of a behavior or feature; write Name or Name(target)'
            )
        inner = match.group(2)
        arguments = tuple(part.strip() for part in inner.split(",")) if inner else ()
        for argument in arguments:
            if NAME.match(argument) is None:
                raise VocabularyError(f'"{argument}" in "{text}" is not a target or parameter')
        return cls(match.group(1), arguments)

    def bound(self, parameters: Mapping[str, str]) -> Use:
        """Return this use with each automaton parameter replaced by its binding.

        Example:
            >>> str(Use("GoTo", ("A",)).bound({"A": "ball"}))
            'GoTo(ball)'
        """
        if not self.arguments:
            return self
        return Use(self.name, tuple(parameters.get(a, a) for a in self.arguments))

    def __str__(self) -> str:
        """Return the text that :meth:`parse` reads."""
        return f"{self.name}({', '.join(self.arguments)})" if self.arguments else self.name
