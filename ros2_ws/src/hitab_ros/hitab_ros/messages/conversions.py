"""Conversions between messages and hitab_core's types, most of which have the same fields."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable
from dataclasses import fields
from operator import attrgetter
from typing import Any

from diagnostic_msgs.msg import KeyValue
from hitab_msgs import msg, srv

from hitab_core import BoundedNumber, Feature, Fix, Remark, RemarkKind, Remedy, Term
from hitab_core.codec import from_dict
from hitab_core.training.operation import Operation


def message_of(kind: Any, data: Any, /, **others: Any) -> Any:
    """Return a message with the fields of a dataclass, except for ``others``.

    `hitab_core.codec.from_dict` reads it.

    Args:
        kind: class of the message.
        data: a dataclass, which may contain others where the message contains messages.
        others: values of further fields of the message.
    """
    names, read, writers = _shared(kind, data.__class__)
    found = dict(zip(names, read(data), strict=True)) | others
    for name, write in writers.items():
        if name not in others:
            found[name] = write(found[name])
    return kind(**found)


@functools.cache
def _shared(kind: Any, data: Any) -> tuple[list[str], Callable[[Any], Any], dict[str, Any]]:
    """Return the shared fields, a function that reads them, and functions that convert some."""
    types = kind.get_fields_and_field_types()
    names = [field.name for field in fields(data) if field.name in types]
    writers = {name: write for name in names if (write := _writer(types[name])) is not None}
    return names, attrgetter(*names), writers


def _writer(of_type: str) -> Callable[[Any], Any] | None:
    inner = of_type.removeprefix("sequence<").removesuffix(">")
    package, _, name = inner.rpartition("/")
    if name == "KeyValue":
        return lambda pairs: pairs_message(dict(pairs).items())
    if name == "Remedy":
        return remedy_messages
    if package == "hitab_msgs":
        write: Callable[[Any], Any] = functools.partial(message_of, getattr(msg, name))
    elif inner == "string":
        write = str  # of a term or an enumeration as well
    else:
        return None
    return write if inner == of_type else lambda values: list(map(write, values))


def pairs_message(pairs: Iterable[tuple[str, str]]) -> list[KeyValue]:
    """Return pairs of texts as a field of a message."""
    return [KeyValue(key=key, value=value) for key, value in pairs]


def pairs_of(message: Iterable[Any]) -> tuple[tuple[str, str], ...]:
    """Return the pairs in a field of a message."""
    return tuple((pair.key, pair.value) for pair in message)


def values_message(values: Iterable[tuple[str, float | None]]) -> list[msg.Value]:
    """Return named numbers as a field of a message; None becomes NaN."""
    return [msg.Value(name=n, value=math.nan if v is None else float(v)) for n, v in values]


def request_of(operation: Operation) -> Any:
    """Return the request for an operation, of the service type with its name."""
    return message_of(getattr(srv, type(operation).__name__).Request, operation)


def remedy_messages(remedies: Iterable[Remedy]) -> list[msg.Remedy]:
    """Return remedies as messages, without duplicates."""
    return [message_of(msg.Remedy, it, code=it.code.name) for it in dict.fromkeys(remedies)]


def remedies_of(messages: Iterable[Any]) -> tuple[Remedy, ...]:
    """Return the remedies in messages, without kinds that this version does not know."""
    return tuple(
        Remedy(Fix[m.code], pairs_of(m.arguments)) for m in messages if m.code in Fix.__members__
    )


def remark_messages(remarks: Iterable[Remark]) -> list[msg.Remark]:
    """Return remarks as messages."""
    return [
        message_of(msg.Remark, it, code=it.code.name, remedy=remedy_messages([it.remedy])[0])
        for it in remarks
    ]


def remarks_of(messages: Iterable[Any]) -> tuple[Remark, ...]:
    """Return the remarks in messages, without kinds that this version does not know."""
    return tuple(
        Remark(RemarkKind[m.code], pairs_of(m.arguments), remedy)
        for m in messages
        for remedy in remedies_of([m.remedy])
        if m.code in RemarkKind.__members__
    )


def numbers_of_behaviors(messages: Iterable[Any]) -> dict[str, tuple[BoundedNumber, ...]]:
    """Return the numbers of the behaviors in messages that take numbers, by name."""
    return {
        Term.parse(behavior.name).name: tuple(
            from_dict(BoundedNumber, number) for number in behavior.numbers
        )
        for behavior in messages
        if behavior.numbers
    }


def feature_message(term: Term, feature: Feature) -> msg.Feature:
    """Return a feature with its targets or parameters as a message."""
    return message_of(msg.Feature, feature, name=str(term), period=feature.scale.period)
