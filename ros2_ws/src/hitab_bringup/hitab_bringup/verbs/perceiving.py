"""The verb that shows what an agent perceives now: perceive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_bringup.verbs.connection import Connection, connection
from hitab_client import console
from hitab_client.command_options import AgentName, JsonPath, SwarmName
from hitab_core import FLAGS, OWN_FEATURES, FeatureKind, Use, shown_unit, shown_value

if TYPE_CHECKING:
    from rich.console import Group

WATCH_S = 0.2
"""How often what is watched is renewed, s."""


def register(app: typer.Typer) -> None:
    """Add this verb to the command."""
    app.command(rich_help_panel="Perform")(perceive)


def perceive(
    agent: AgentName,
    features: Annotated[
        list[str] | None,
        typer.Argument(
            help="Features, such as DistanceTo(ball). Default: all, with all targets.",
            show_default=False,
        ),
    ] = None,
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Keep it up to date.")] = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show what an agent perceives now: each feature with its value and unit.

    A feature whose sensor is silent has no value; below the table is what is wrong. Angles are in
    degrees here, and in the feature's own unit in JSON. While the agent performs, the flags and
    timers of the automata that are active are shown, too.

    Examples:

      hitab perceive keeper_1

      hitab perceive keeper_1 "DistanceTo(ball)" --watch
    """
    with connection(swarm) as swarm_up:
        words = _Words.asked(swarm_up, agent)
        chosen = list(features or words.all())
        perceived = _read(swarm_up, agent, chosen, words)
        if watch:
            _watch(swarm_up, agent, chosen, words)
            return
        if json != "-":
            console.out().print(_rendered(*perceived))
        console.write_json(json, _data(agent, *perceived))


@dataclass(frozen=True)
class _Words:
    """The features of an agent.

    Attributes:
        features: with parameters, such as ``DistanceTo(X)``.
        kinds, units: of them, by name.
        targets: to which parameters can be bound.
    """

    features: Sequence[str]
    kinds: Mapping[str, str]
    units: Mapping[str, str]
    targets: Sequence[str]

    @classmethod
    def asked(cls, swarm_up: Connection, agent: str) -> _Words:
        told = swarm_up.agents.vocabulary(agent)
        return cls(
            [feature.name for feature in told.features],
            {Use.parse(f.name).name: f.kind for f in told.features},
            {Use.parse(f.name).name: f.unit for f in told.features},
            list(told.targets),
        )

    def all(self) -> list[str]:
        """Return all features of the domain, bound to all targets."""
        own = {use.name for use in OWN_FEATURES}
        uses = [use for use in map(Use.parse, self.features) if use.name not in own]
        return [
            str(Use(use.name, targets))
            for use in uses
            for targets in product(self.targets, repeat=len(use.arguments))
            if len(set(targets)) == len(targets)
        ]


@dataclass(frozen=True)
class _Reading:
    """One feature now; `automaton` is empty unless it is a flag or timer of that automaton."""

    automaton: str
    feature: str
    value: float
    kind: str
    unit: str

    @property
    def shown(self) -> str:
        """The value for people."""
        if math.isnan(self.value):
            return "no value"
        if self.kind == FeatureKind.BOOLEAN:
            return "yes" if self.value else "no"
        value = shown_value(self.value, self.unit)
        return f"{value:.1f}" if abs(value) >= 100.0 else f"{value:.3g}"


def _read(
    swarm_up: Connection, agent: str, chosen: Sequence[str], words: _Words
) -> tuple[list[_Reading], list[str]]:
    """Return the features, and the agent's faults."""
    told = swarm_up.agents.read_features(agent, list(chosen))
    own = {use.name for use in OWN_FEATURES}
    found = []
    for read in told.readings:
        name = Use.parse(read.feature).name
        if read.automaton and name not in own:
            continue  # it is among the chosen ones, or not asked for
        kind = FeatureKind.BOOLEAN if name in FLAGS else words.kinds.get(name, "")
        unit = words.units.get(name, "")
        found.append(_Reading(read.automaton, read.feature, read.value, kind, unit))
    found.sort(key=lambda reading: bool(reading.automaton))
    status = swarm_up.agents.statuses.get(agent)
    faults = [*(status.faults if status is not None else ()), told.message]
    return found, [*dict.fromkeys(filter(None, faults))]


def _watch(swarm_up: Connection, agent: str, chosen: Sequence[str], words: _Words) -> None:
    def shown() -> Group:
        return _rendered(*_read(swarm_up, agent, chosen, words))

    with console.live(shown()) as update:
        while True:
            swarm_up.link.spin_until(lambda: False, WATCH_S)
            update(shown())


def _rendered(readings: Sequence[_Reading], faults: Sequence[str]) -> Group:
    from rich.console import Group

    rows = [
        (
            f"{one.feature} of {one.automaton}" if one.automaton else one.feature,
            one.shown,
            "" if math.isnan(one.value) else shown_unit(one.unit),
        )
        for one in readings
    ]
    shown = [console.line(fault, "red") for fault in faults]
    return Group(console.table(("feature", "value", "unit"), rows), *shown)


def _data(agent: str, readings: Sequence[_Reading], faults: Sequence[str]) -> dict[str, Any]:
    return {
        "agent": agent,
        "features": [
            {
                "automaton": one.automaton,
                "name": one.feature,
                "value": None if math.isnan(one.value) else one.value,
                "kind": str(one.kind),
                "unit": one.unit,
            }
            for one in readings
        ],
        "faults": faults,
    }
