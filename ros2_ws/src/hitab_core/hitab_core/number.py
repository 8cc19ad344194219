"""The numbers of a basic behavior, such as the direction of ``RunTowards(direction=40)``.

They are written after the targets, ``name=value``. A state of an automaton has none: its numbers
are learned from the commanded ones (`hitab_core.regression`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hitab_core.term import Term
from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.vocabulary import unknown


@dataclass(frozen=True, slots=True)
class BoundedNumber:
    """A number that a basic behavior is performed with.

    Attributes:
        name: name, as in ``direction=40``.
        low, high: bounds, in ``unit``, both allowed.
        circular: ``high`` is where ``low`` is, as for directions from -180 to 180 degrees.
    """

    name: str
    low: float
    high: float
    unit: str = ""
    circular: bool = False

    def __str__(self) -> str:
        """Return the number with its bounds, for errors."""
        return f"{self.name} from {self.low:g} to {self.high:g}{self.unit and ' ' + self.unit}"


def wrong_with(values: Sequence[float], wanted: Sequence[BoundedNumber]) -> list[str]:
    """Return the faults of an example's stored numbers, worded to follow the example's number."""
    if not values:
        return []
    if len(values) != len(wanted):
        return [f"has {len(values)} numbers for a behavior that takes {len(wanted)}; correct it"]
    return [
        f"has {value:g} as {number.name}; give {number}"
        for value, number in zip(values, wanted, strict=True)
        if not number.low <= value <= number.high
    ]


def without_numbers(term: Term) -> Term:
    """Return a term with its targets alone.

    Examples:
        >>> str(without_numbers(Term.parse("RunTowards(direction=40)")))
        'RunTowards'
    """
    return Term(term.name, tuple(a for a in term.arguments if "=" not in a))


def with_numbers(term: Term, values: Sequence[float], wanted: Sequence[BoundedNumber]) -> Term:
    """Return a term with numbers, as it is commanded; none: as it is.

    Examples:
        >>> str(with_numbers(Term("RunTowards"), [40.0], [BoundedNumber("direction", -180, 180)]))
        'RunTowards(direction=40)'
    """
    given = (f"{n.name}={value:.6g}" for n, value in zip(wanted, values, strict=bool(values)))
    return Term(term.name, (*term.arguments, *given))


def numbers_of(term: Term, wanted: Sequence[BoundedNumber]) -> tuple[float, ...]:
    """Return the numbers that a term gives, in the order of the behavior's own.

    Raises:
        VocabularyError: if one is unknown, missing, there twice, no number or out of its bounds.

    Examples:
        >>> direction = BoundedNumber("direction", -180, 180)
        >>> numbers_of(Term.parse("RunTowards(direction=40)"), [direction])
        (40.0,)
    """
    names = [number.name for number in wanted]
    given: dict[str, str] = {}
    for argument in term.arguments:
        name, is_number, text = (part.strip() for part in argument.partition("="))
        if not is_number:
            continue
        if name not in names:
            what = f' in "{term}"'
            raise VocabularyError(unknown("number", name, names, what))
        if name in given:
            raise VocabularyError(f'"{term}" gives {name} twice; give it once')
        given[name] = text
    return tuple(_checked(term, number, given, wanted) for number in wanted)


def _checked(
    term: Term, number: BoundedNumber, given: Mapping[str, str], wanted: Sequence[BoundedNumber]
) -> float:
    text = given.get(number.name, "")
    value = _float(text)
    if not number.low <= value <= number.high:
        where = f'{number.name} of "{term}" is {text}' if text else f'"{term.name}" needs {number}'
        # A text that can be typed: all numbers, with the valid ones that were given.
        values = [_float(given.get(n.name, "")) for n in wanted]
        right = [
            value if n.low <= value <= n.high else (n.low + n.high) / 2.0
            for n, value in zip(wanted, values, strict=True)
        ]
        targets = tuple(a for a in without_numbers(term).arguments if math.isnan(_float(a)))
        example = with_numbers(Term(term.name, targets), right, wanted)
        bounds = f"; give {number}" if text else ""
        raise VocabularyError(f"{where}{bounds}, for example {example}")
    return value


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
