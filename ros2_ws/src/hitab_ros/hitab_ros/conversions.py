"""Conversions between messages and hitab_core's types, most of which have the same fields."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from operator import attrgetter
from typing import Any, TypeVar

from diagnostic_msgs.msg import KeyValue
from hitab_msgs import msg, srv

from hitab_core import (
    BoundedNumber,
    Example,
    ExampleKind,
    Feature,
    Fix,
    Remark,
    RemarkKind,
    Remedy,
    Scale,
    Term,
)
from hitab_core.assistant import TrainingCost
from hitab_core.operation import Operation, Outcome
from hitab_core.orders import Order, Report

Data = TypeVar("Data")
Op = TypeVar("Op", bound=Operation)


@functools.cache
def _shared(kind: Any, data: Any) -> tuple[tuple[str, ...], Callable[[Any], tuple[Any, ...]]]:
    """Return the fields that a message and a dataclass share, and a function that reads them."""
    shared = {field.name for field in fields(data)}
    names = tuple(name for name in kind.get_fields_and_field_types() if name in shared)
    return names, attrgetter(*names)


def message_of(kind: Any, data: Any, /, **others: Any) -> Any:
    """Return a message with the values of a dataclass's fields, except for ``others``."""
    kinds: Any = (kind, type(data))
    names, read = _shared(*kinds)
    return kind(**{**dict(zip(names, read(data), strict=True)), **others})


def data_of(kind: type[Data], message: Any, /, **others: Any) -> Data:
    """Return a dataclass with the values of a message's fields, except for ``others``."""
    kinds: Any = (type(message), kind)
    names, read = _shared(*kinds)
    return kind(**{**dict(zip(names, read(message), strict=True)), **others})


def pairs_message(pairs: Iterable[tuple[str, str]]) -> list[KeyValue]:
    """Return pairs of texts as a field of a message."""
    return [KeyValue(key=key, value=value) for key, value in pairs]


def pairs_of(message: Iterable[Any]) -> tuple[tuple[str, str], ...]:
    """Return the pairs in a field of a message."""
    return tuple((pair.key, pair.value) for pair in message)


def values_message(values: Iterable[tuple[str, float | None]]) -> list[msg.Value]:
    """Return named numbers as a field of a message; None becomes NaN."""
    return [msg.Value(name=n, value=math.nan if v is None else float(v)) for n, v in values]


def operation_of(kind: type[Op], request: Any) -> Op:
    """Return the operation that a request, or a message on the command topic, asks for."""
    given: dict[str, Any] = {}
    for field in fields(kind):
        value = getattr(request, field.name)
        if field.default_factory is dict:
            value = dict(pairs_of(value))
        given[field.name] = value if isinstance(value, (bool, int, float, str, dict)) else [*value]
    return kind(**given)


def request_of(operation: Operation) -> Any:
    """Return the request for an operation, of the service type with its name."""
    request = getattr(srv, type(operation).__name__).Request()
    for field in fields(operation):
        value = getattr(operation, field.name)
        if field.default_factory is dict:
            value = pairs_message(value.items())
        setattr(request, field.name, list(value) if isinstance(value, (tuple, list)) else value)
    return request


def fill_in(response: Any, outcome: Outcome) -> None:
    """Write an outcome into the reply to a request, as far as the reply has its fields."""
    for field in fields(outcome):
        if hasattr(response, field.name):
            value = getattr(outcome, field.name)
            value = remedy_messages(value) if field.name == "remedies" else value
            setattr(response, field.name, value)


def remedy_messages(remedies: Iterable[Remedy]) -> list[msg.Remedy]:
    """Return remedies as messages, without duplicates."""
    return [
        msg.Remedy(code=remedy.code.name, arguments=pairs_message(remedy.arguments))
        for remedy in dict.fromkeys(remedies)
    ]


def remedies_of(messages: Iterable[Any]) -> tuple[Remedy, ...]:
    """Return the remedies in messages, without kinds that this version does not know."""
    return tuple(
        Remedy(Fix[m.code], pairs_of(m.arguments)) for m in messages if m.code in Fix.__members__
    )


def remark_messages(remarks: Iterable[Remark]) -> list[msg.Remark]:
    """Return remarks as messages."""
    return [
        msg.Remark(
            code=remark.code.name,
            arguments=pairs_message(remark.arguments),
            remedy=remedy_messages([remark.remedy])[0],
        )
        for remark in remarks
    ]


def remarks_of(messages: Iterable[Any]) -> tuple[Remark, ...]:
    """Return the remarks in messages, without kinds that this version does not know."""
    return tuple(
        Remark(RemarkKind[m.code], pairs_of(m.arguments), remedy)
        for m in messages
        for remedy in remedies_of([m.remedy])
        if m.code in RemarkKind.__members__
    )


def example_message(example: Example) -> msg.Example:
    """Return an example as a message."""
    return message_of(msg.Example, example, values=example.features, kind=example.kind.value)


def example_of(message: Any) -> Example:
    """Return the example in a message."""
    return data_of(
        Example,
        message,
        features=tuple(message.values),
        kind=ExampleKind(message.kind),
        readings=tuple(message.readings),
        numbers=tuple(message.numbers),
    )


def number_messages(numbers: Iterable[BoundedNumber]) -> list[msg.Number]:
    """Return the numbers of a behavior as messages."""
    return [message_of(msg.Number, number) for number in numbers]


def numbers_of_behaviors(messages: Iterable[Any]) -> dict[str, tuple[BoundedNumber, ...]]:
    """Return the numbers of the behaviors in messages that take numbers, by name."""
    return {
        Term.parse(behavior.name).name: tuple(data_of(BoundedNumber, n) for n in behavior.numbers)
        for behavior in messages
        if behavior.numbers
    }


def term_of(name: str, arguments: Sequence[str]) -> Term:
    """Return a behavior with its targets, which may be part of the name, as in ``GoTo(ball)``.

    Raises:
        VocabularyError: if the name has an invalid form.
    """
    term = Term.parse(name)
    return Term(term.name, (*term.arguments, *arguments))


def order_message(commander: str, order: Order) -> msg.Order:
    """Return an order as a message."""
    return message_of(
        msg.Order,
        order,
        commander=commander,
        order=order.name,
        behaviors=pairs_message(order.behaviors.items()),
    )


def order_of(message: msg.Order) -> Order:
    """Return the order in a message."""
    return data_of(
        Order,
        message,
        name=message.order,
        behaviors=dict(pairs_of(message.behaviors)),
        report=tuple(message.report),
    )


def report_message(report: Report) -> msg.Report:
    """Return a report as a message."""
    return message_of(msg.Report, report)


def feature_message(name: str, feature: Feature, scale: Scale | None = None) -> msg.Feature:
    """Return a feature as a message.

    Args:
        name: the feature's name with its targets or parameters.
        feature: the feature's declaration in the domain.
        scale: scale of the feature's values; None if not requested.
    """
    message = msg.Feature(name=name, kind=feature.kind.value, unit=feature.unit)
    message.description = feature.description
    if scale is not None:
        message.kind, message.period = scale.kind.value, float(scale.period)
        message.categories = list(scale.categories)
    return message


def cost_message(cost: TrainingCost) -> msg.TrainingCost:
    """Return a training's cost as a message."""
    return message_of(msg.TrainingCost, cost)


def cost_of(message: Any) -> TrainingCost:
    """Return the cost of a training in a message."""
    return data_of(TrainingCost, message)
