"""One codec for dataclasses: the journal, behavior files and messages have their fields' names.

Plain data is what JSON and YAML hold: a missing value (NaN) is None, a term or an enumeration its
text, a tuple a list. A message is read like plain data; `hitab_ros.messages.conversions` writes
messages.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from operator import attrgetter
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from hitab_core.term import Term

Data = TypeVar("Data")
Convert = Callable[[Any], Any]


def to_dict(data: Any, without: Iterable[str] = ()) -> dict[str, Any]:
    """Return a dataclass as plain data, except for some of its fields."""
    return {
        name: write(getattr(data, name))
        for name, write, _ in _fields(data.__class__)
        if name not in without
    }


def from_dict(kind: type[Data], record: Any, /, **others: Any) -> Data:
    """Return a dataclass with the fields of a record, except for ``others``.

    Fields that the record lacks have their defaults, and entries that are no fields are ignored.

    Args:
        kind: the dataclass.
        record: plain data, or a message.
        others: values of further fields.

    Raises:
        TypeError, ValueError: if a value has another type, or a field without default is missing.
    """
    return kind(**fields_of(kind, record, others), **others)


def fields_of(kind: Any, record: Any, without: Iterable[str] = ()) -> dict[str, Any]:
    """Return the fields that a dataclass and a record share; see `from_dict`."""
    if isinstance(record, dict):
        return {
            name: read(record[name])
            for name, _, read in _fields(kind)
            if name in record and name not in without
        }
    shared = _shared(kind, record.__class__)
    return {name: read(getattr(record, name)) for name, read in shared if name not in without}


def plain_values(values: Iterable[float]) -> list[float | None]:
    """Return values as plain data."""
    return [value if value == value else None for value in values]


def values_of(plain: Collection[Any]) -> tuple[float, ...]:
    """Return the values that `plain_values` represents."""
    try:
        return tuple(map(float, plain))
    except TypeError:  # one is missing
        return tuple([math.nan if value is None else float(value) for value in plain])


@functools.cache
def _fields(kind: Any) -> tuple[tuple[str, Convert, Convert], ...]:
    """Return the name of each field, and the functions that write and read it."""
    hints = get_type_hints(kind)
    return tuple((one.name, *_converters(hints[one.name])) for one in fields(kind) if one.init)


@functools.cache
def _shared(kind: Any, record: Any) -> list[tuple[str, Convert]]:
    return [(name, read) for name, _, read in _fields(kind) if hasattr(record, name)]


def _converters(hint: Any) -> tuple[Convert, Convert]:
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (tuple, Sequence) and inner[1:] in ((), (...,)):
        if inner[0] is float:
            return plain_values, values_of
        write, read = _converters(inner[0])
        return lambda them: list(map(write, them)), lambda them: tuple(map(read, them))
    if origin is Mapping:
        return dict, _mapping
    if not isinstance(hint, type):
        return _as_it_is, _as_it_is
    if hint in (str, int, float, bool):
        return _as_it_is, hint
    if issubclass(hint, Enum):
        return attrgetter("value"), hint
    if hint is Term:
        return str, Term.parse
    if is_dataclass(hint):
        return to_dict, functools.partial(from_dict, hint)
    return _as_it_is, _as_it_is


def _mapping(pairs: Any) -> dict[str, Any]:
    """Return a mapping, which a message holds as a list of pairs."""
    return dict(pairs) if isinstance(pairs, Mapping) else {pair.key: pair.value for pair in pairs}


def _as_it_is(value: Any) -> Any:
    return value
