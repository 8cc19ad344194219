"""The domain of a kind of commander: orders are its basic behaviors, the group has its features.

The domain depends on the kind alone, not on the subordinates, so all commanders of one kind can
use the same library. The domain's version is a digest of its definitions: if an order or a feature
is redefined, behaviors that were trained with the earlier definition are refused.
"""

from __future__ import annotations

from collections.abc import Container, Iterable
from dataclasses import asdict, replace
from functools import partial
from typing import Any

from hitab_commander.commander_body import CommanderBody
from hitab_commander.kinds.kind import (
    CommanderKind,
    GroupFeature,
    Observation,
    OrderMap,
    Over,
    Pick,
)
from hitab_core import BasicBehavior, Domain, Feature, FeatureKind, Target
from hitab_core.library import checksum

FRACTION_SILENT = "FractionSilent"
LINK = "hitab_commander.commander_node:link"


def commander_domain(kind: CommanderKind) -> Domain:
    """Return the domain of all commanders of a kind.

    Raises:
        VocabularyError: if a name is malformed or used twice.
    """
    domain = Domain.of(
        kind.name,
        _meaning(kind),
        lambda name: CommanderBody(name, kind),
        behaviors=[_behavior(order) for order in kind.orders],
        features=[*(_feature(feature) for feature in kind.features), _SILENT],
        targets=[_target(pick) for pick in kind.targets],
        link=LINK,
    )
    return replace(domain, version_of=partial(_meaning, kind))


def _meaning(kind: CommanderKind, words: Container[str] | None = None) -> str:
    def of(defined: Iterable[Any]) -> dict[str, Any]:
        return {one.name: asdict(one) for one in defined if words is None or one.name in words}

    described = {
        "orders": of(kind.orders),
        "features": of(kind.features),
        "targets": of(kind.targets),
    }
    return checksum(described)[:12]


def _behavior(order: OrderMap) -> BasicBehavior:
    def give(body: CommanderBody, *chosen: str | None) -> None:
        body.give(order, *chosen)

    description = ", ".join(
        f"{receiver or 'others' if order.behaviors.keys() != {''} else 'all'}: "
        f"{'continue' if behavior is None else behavior or 'nothing'}"
        for receiver, behavior in order.behaviors.items()
    )
    parameters = (order.parameter,) if order.parameter else ()
    return BasicBehavior(order.name, give, give, parameters=parameters, description=description)


def _feature(feature: GroupFeature) -> Feature:
    of = feature.of
    question = feature.over is Over.VALUE and of.is_question
    boolean = feature.over in (Over.ANY, Over.ALL) or question
    kind = FeatureKind.BOOLEAN if boolean else FeatureKind.CONTINUOUS
    description = f"{feature.over} {feature.part or _in_words(of)}"
    if feature.role:
        description += f", of those with role {feature.role}"
    return Feature(
        feature.name,
        lambda body, *chosen: body.feature(feature, *chosen),
        kind,
        unit="m" if feature.over is Over.GROUP else "",
        parameters=(feature.parameter,) if feature.parameter else (),
        description=description,
    )


def _in_words(of: Observation) -> str:
    text = of.flag or (f"active {of.active}" if of.active else of.feature)
    if of.below is not None:
        text += f" below {of.below:g}"
    return text + (f" above {of.above:g}" if of.above is not None else "")


_SILENT = Feature(
    FRACTION_SILENT,
    lambda body: body.fraction_silent,
    description="share of the subordinates that are silent",
)


def _target(pick: Pick) -> Target:
    chosen_by = f"number {pick.number}" if pick.number else f"{pick.over} {_in_words(pick.of)}"
    return Target(pick.name, lambda body: body.picked(pick), f"the subordinate: {chosen_by}")
