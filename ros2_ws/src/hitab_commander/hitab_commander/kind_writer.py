"""Writes kinds of commanders in the format that `hitab_commander.kind_reader` reads."""

from __future__ import annotations

from typing import Any

import yaml

from hitab_commander.kind import CommanderKind, GroupFeature, Observation, OrderMap, Over, Pick
from hitab_commander.kind_reader import KEEP, NOTHING, OTHERS_WORD
from hitab_core.commanding import OTHERS


def kind_text(kind: CommanderKind) -> str:
    """Return the text of a file that describes a kind."""
    described: dict[str, Any] = {
        "commander": kind.name,
        "orders": {_label(order): _order(order) for order in kind.orders},
        "features": {_label(feature): _feature(feature) for feature in kind.features},
        "targets": {pick.name: _target(pick) for pick in kind.targets},
        "deadline": kind.deadline,
        "rate": kind.rate,
        "report_period": kind.report_period,
    }
    return yaml.safe_dump({k: v for k, v in described.items() if v != {}}, sort_keys=False)


def _label(named: OrderMap | GroupFeature) -> str:
    return f"{named.name}({named.parameter})" if named.parameter else named.name


def _order(order: OrderMap) -> dict[str, str]:
    return {
        OTHERS_WORD if receiver == OTHERS else receiver: (
            KEEP if behavior is None else behavior or NOTHING
        )
        for receiver, behavior in order.behaviors.items()
    }


def _feature(feature: GroupFeature) -> dict[str, Any]:
    if feature.over is Over.GROUP:
        return {feature.over.value: feature.part}
    return {feature.over.value: _observed(feature.of), **_rest(feature.of, feature.role)}


def _target(pick: Pick) -> dict[str, Any]:
    if pick.number:
        return {"number": pick.number, **_rest(pick.of, pick.role)}
    return {pick.over.value: _observed(pick.of), **_rest(pick.of, pick.role)}


def _observed(of: Observation) -> Any:
    return {"active": of.active} if of.active else of.flag or of.feature


def _rest(of: Observation, role: str) -> dict[str, Any]:
    rest = {"below": of.below, "above": of.above, "role": role or None}
    return {key: value for key, value in rest.items() if value is not None}
