"""The parameters of a kind of world: a frozen dataclass that refuses invalid values by name.

For example::

    @dataclass(frozen=True)
    class PuddleParameters(Parameters):
        WORLD = "puddle"
        LIMITS = {"width": at_least(2.0, "m"), "leaves": NOT_NEGATIVE}

        width: float = 5.0
        leaves: int = 3
        rain: bool = False

Independent of ROS; `hitab_world.node.ros_parameters` declares such a class as parameters of a
node.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from types import MappingProxyType
from typing import Any, ClassVar, Self

from hitab_core import HitabError, has


class ParameterError(HitabError, ValueError):
    """An invalid parameter of a world; the message names the parameter and its limit."""


@dataclass(frozen=True, slots=True)
class Limit:
    """The limit of a parameter.

    Attributes:
        words: the limit in words that follow "it must", such as ``be at least 2 m``.
        holds: returns whether a value of the right type is within the limit.
    """

    words: str
    holds: Callable[[Any], bool]


POSITIVE = Limit("be above 0", lambda value: bool(value > 0))
NOT_NEGATIVE = Limit("not be negative (0 or more)", lambda value: bool(value >= 0))
FRACTION = Limit("lie between 0 and 1, exclusive", lambda value: bool(0 < value < 1))


def at_least(least: float, unit: str = "") -> Limit:
    """Return the limit of a number with a smallest value."""
    return Limit(f"be at least {least:g} {unit}".rstrip(), lambda value: bool(value >= least))


def between(low: float, high: float) -> Limit:
    """Return the limit of a number between two others, inclusive."""
    return Limit(f"lie between {low:g} and {high:g}", lambda value: bool(low <= value <= high))


def one_of(*names: str) -> Limit:
    """Return the limit of a text that is one of several."""
    return Limit(f"be one of: {', '.join(names)}", lambda value: value in names)


@dataclass(frozen=True)
class Parameters:
    """Base class of the parameters of a kind of world: fields of simple types.

    The types are bool, int, float, str and ``tuple[str, ...]``. A subclass gives every field a
    default. It checks conditions on several parameters in its own ``__post_init__``, after this
    one.

    Attributes:
        WORLD: the world's name in errors.
        LIMITS: limits of single parameters, by name; all other numbers must be above 0.
    """

    WORLD: ClassVar[str]
    LIMITS: ClassVar[Mapping[str, Limit]] = MappingProxyType({})

    def __post_init__(self) -> None:
        """Refuse invalid values.

        Raises:
            ParameterError: naming the parameter and its limit.
        """
        for figure in fields(self):
            value = getattr(self, figure.name)
            # Types are text in modules with "from __future__ import annotations".
            kind = getattr(figure.type, "__name__", figure.type)
            must = _missed(kind, value, self.LIMITS.get(figure.name))
            if must:
                raise ParameterError(f"{figure.name} is {value!r}; it must {must}")

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name, as `from_dict` accepts them."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """Return parameters with these values and defaults for the rest.

        Raises:
            ParameterError: if a parameter is unknown or its value invalid.
        """
        known = [figure.name for figure in fields(cls)]
        for name in values:
            if name not in known:
                raise ParameterError(
                    f'there is no {cls.WORLD} parameter "{name}" {has(known, name)}'
                )
        return cls(**values)


def _missed(kind: Any, value: Any, limit: Limit | None) -> str:
    """Return the requirement that a field's value misses; "" if it is valid."""
    whole = isinstance(value, int) and not isinstance(value, bool)
    if kind in ("int", "float"):
        limit = limit or POSITIVE
        if kind == "int":
            return "" if whole and limit.holds(value) else f"be a whole number and {limit.words}"
        if not whole and not isinstance(value, float):
            return "be a number"
        if not math.isfinite(value):
            return "be finite"
    elif kind.startswith("tuple"):
        texts = isinstance(value, tuple) and all(isinstance(text, str) for text in value)
        return "" if texts else "be a list of texts"
    elif not isinstance(value, bool if kind == "bool" else str):
        return "be true or false" if kind == "bool" else "be text"
    return "" if limit is None or limit.holds(value) else limit.words
