"""Conversions between messages and the engine's own types."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from typing import Any

from hitab_msgs import msg

from hitab_core import Do, Example, ExampleKind, Feature, Remedy, Scale, Use
from hitab_core.commanding import Order, Report
from hitab_core.training import TrainingCost


def remedy_messages(remedies: Iterable[Remedy]) -> list[msg.Remedy]:
    """Return remedies as messages, each once."""
    return [
        msg.Remedy(
            code=remedy.code.name,
            names=[name for name, _ in remedy.arguments],
            values=[value for _, value in remedy.arguments],
        )
        for remedy in dict.fromkeys(remedies)
    ]


def remedies_of(messages: Iterable[Any]) -> tuple[Remedy, ...]:
    """Return the remedies in messages, without those that this version does not know."""
    return tuple(
        Remedy(Do[m.code], tuple(zip(m.names, m.values, strict=False)))
        for m in messages
        if m.code in Do.__members__
    )


def example_message(example: Example) -> msg.Example:
    """Return an example as a message."""
    return msg.Example(
        number=example.number,
        state=example.state,
        next_state=example.next_state,
        values=list(example.features),
        kind=example.kind.value,
        command=example.command,
        cycle=example.cycle,
        ago=example.ago,
        readings=list(example.readings),
    )


def example_of(message: Any) -> Example:
    """Return the example in a message."""
    return Example(
        message.state,
        tuple(message.values),
        message.next_state,
        ExampleKind(message.kind),
        message.number,
        message.command,
        message.cycle,
        message.ago,
        tuple(message.readings),
    )


def use_of(name: str, arguments: Sequence[str]) -> Use:
    """Return a behavior with its targets, which may be in the name, as in ``GoTo(ball)``.

    Raises:
        VocabularyError: if the name has another form.
    """
    use = Use.parse(name)
    return Use(use.name, (*use.arguments, *arguments))


def order_message(commander: str, order: Order) -> msg.Order:
    """Return an order as a message."""
    return msg.Order(
        commander=commander,
        epoch=order.epoch,
        sequence=order.sequence,
        order=order.name,
        receivers=list(order.behaviors),
        behaviors=list(order.behaviors.values()),
        report=list(order.report),
        report_position=order.report_position,
        report_states=order.report_states,
        report_period=order.report_period,
        round=order.round,
    )


def order_of(message: msg.Order) -> Order:
    """Return the order in a message; receivers without a behavior are left out."""
    return Order(
        message.epoch,
        message.sequence,
        message.order,
        dict(zip(message.receivers, message.behaviors, strict=False)),
        tuple(message.report),
        message.report_position,
        message.report_states,
        message.report_period,
        message.round,
    )


def report_message(report: Report) -> msg.Report:
    """Return a report as a message, which has the same fields and can be read as a report."""
    return msg.Report(
        agent=report.agent,
        epoch=report.epoch,
        sequence=report.sequence,
        waits=report.waits,
        mode=report.mode,
        path=list(report.path),
        flags=list(report.flags),
        values=report.values,
        position=report.position,
        cycle=report.cycle,
        episode=report.episode,
        seed=report.seed,
        seconds=report.seconds,
        round=report.round,
        look=report.look,
        restart=report.restart,
    )


def feature_message(name: str, feature: Feature, scale: Scale | None = None) -> msg.Feature:
    """Return a feature as a message.

    Args:
        name: with its targets or parameters.
        feature: as the domain declares it.
        scale: of its values; None: it is not asked for.
    """
    told = msg.Feature(name=name, kind=feature.kind.value, unit=feature.unit)
    told.description = feature.description
    if scale is not None:
        told.kind, told.period = scale.kind.value, float(scale.period)
        told.categories = list(scale.categories)
    return told


def cost_message(cost: TrainingCost) -> msg.TrainingCost:
    """Return what a training cost as a message, which has the same fields."""
    return msg.TrainingCost(**asdict(cost))


def costs_of(report: Any) -> list[TrainingCost]:
    """Return the costs in an answer of GetReport.srv, oldest first."""
    names = [field.name for field in fields(TrainingCost)]
    return [TrainingCost(*(getattr(cost, name) for name in names)) for cost in report.costs]
