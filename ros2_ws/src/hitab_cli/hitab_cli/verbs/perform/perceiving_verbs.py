"""Verbs that show an agent's percept and the reasons of its transitions: perceive, why."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import Annotated, Any

import typer

from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import console
from hitab_client.terminal.cli_options import AgentName, JsonPath, SwarmName
from hitab_core import FLAGS, OWN_NAMES, FeatureKind, Term, shown_unit, shown_value
from hitab_ros.timing import REFRESH_S


def perceive(
    agent: AgentName,
    features: Annotated[list[str] | None, typer.Argument()] = None,
    watch: Annotated[bool, typer.Option("--watch", "-w")] = False,
    cycle: Annotated[int, typer.Option("--cycle", show_default=False)] = 0,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show an agent's present percept: each feature with its value and unit.

    A feature whose sensor is silent has no value; faults are listed below the table. Angles are in
    degrees, but in JSON in the feature's own unit. While the agent performs, the flags and timers
    of the active automata are shown, too.

    Args:
        features: Features, such as DistanceTo(ball). Default: all, with all targets.
        watch: Keep it up to date.
        cycle: In a training, the percept of this cycle of the last minute, as `hitab why` tells
            them, with the states of then. Default: now.

    Examples:
      hitab perceive keeper_1
      hitab perceive keeper_1 --cycle 424
      hitab perceive keeper_1 "DistanceTo(ball)" --watch
    """
    with connection(swarm) as swarm_up:
        words = swarm_up.agents.vocabulary(agent)
        chosen = list(features or _all(words))
        if watch and cycle:
            raise typer.BadParameter(
                "--watch shows the present, and --cycle a moment that is past"
            )
        if watch:
            swarm_up.watch(lambda: _rendered(_read(swarm_up, agent, chosen, words)))
        data = _read(swarm_up, agent, chosen, words, cycle)
        console.show(json, data, *_rendered(data))


def why(agent: AgentName, swarm: SwarmName = None) -> None:
    """Show each change of state from now on with its reason: features, or a command.

    End with Ctrl-C. If the world is paused, step it in another terminal.

    Example:
      hitab why keeper_1
    """
    with connection(swarm) as swarm_up:
        from hitab_msgs.msg import TransitionEvent

        from hitab_ros import names, qos

        agents = swarm_up.agents
        known = {Term.parse(f.name).name: f for f in agents.vocabulary(agent).features}

        def seen(name: str, value: float) -> str:
            feature = known.get(Term.parse(name).name)
            kind, unit = (feature.kind, feature.unit) if feature else (FeatureKind.BOOLEAN, "")
            return f"{name} = {_value(value, kind, unit)} {shown_unit(unit)}".rstrip()

        def show_event(event: TransitionEvent) -> None:
            looked_at = ", ".join(seen(f.name, f.value) for f in event.features)
            because = "commanded" if event.commanded else looked_at or "always"
            change = f"{'/'.join(event.automaton)}: {event.from_state} -> {event.to_state}"
            console.say(f"cycle {event.cycle}: {change} ({because})")

        topic = names.of_agent(agent, names.TRANSITIONS, agents.prefix)
        swarm_up.link.subscribe(TransitionEvent, topic, show_event, qos.EVENTS)
        console.note(f"{agent} is {agents.statuses[agent].mode}; Ctrl-C ends this")
        while True:
            swarm_up.link.spin(REFRESH_S)


def _all(words: Any) -> Iterator[str]:
    """Yield all features of the domain, bound to all targets."""
    for term in (Term.parse(feature.name) for feature in words.features):
        for targets in product(words.targets, repeat=len(term.arguments)):
            if term.name not in OWN_NAMES and len(set(targets)) == len(targets):
                yield str(Term(term.name, targets))


def _read(
    swarm_up: Connection, agent: str, chosen: list[str], words: Any, cycle: int = 0
) -> dict[str, Any]:
    """Return the features now or in a cycle, the states, and the agent's faults, as plain data."""
    answer = swarm_up.agents.read_features(agent, chosen, cycle)
    known = {Term.parse(feature.name).name: feature for feature in words.features}
    found = []
    for read in answer.readings:
        name = Term.parse(read.feature).name
        if read.automaton and name not in OWN_NAMES:
            continue  # listed with the requested features, if at all
        kind = known[name].kind if name in known else ""
        found.append(
            {
                "automaton": read.automaton,
                "name": read.feature,
                "value": None if math.isnan(read.value) else read.value,
                "kind": str(FeatureKind.BOOLEAN) if name in FLAGS else kind,
                "unit": known[name].unit if name in known else "",
            }
        )
    status = swarm_up.agents.statuses.get(agent)
    faults = [*(status.faults if status is not None else ()), answer.message]
    return {
        "agent": agent,
        "active_path": list(answer.active_path),
        "preview": answer.preview.state,
        "features": sorted(found, key=lambda reading: bool(reading["automaton"])),
        "faults": [*dict.fromkeys(filter(None, faults))],
    }


def _rendered(data: dict[str, Any]) -> list[Any]:
    rows = [
        (
            f"{one['name']} of {one['automaton']}" if one["automaton"] else one["name"],
            _value(**one),
            "" if one["value"] is None else shown_unit(one["unit"]),
        )
        for one in data["features"]
    ]
    faults = [console.line(fault, "red") for fault in data["faults"]]
    path = f"in {'/'.join(data['active_path'])}" if data["active_path"] else ""
    next_state = f"would choose {data['preview']}" if data["preview"] else ""
    states = ", ".join(filter(None, (path, next_state)))
    shown = [states] if states else []
    return [console.table(("feature", "value", "unit"), rows), *shown, *faults]


def _value(value: float | None, kind: str, unit: str, **_: Any) -> str:
    """Return a value for people."""
    if value is None or math.isnan(value):
        return "no value"
    if kind == FeatureKind.BOOLEAN:
        return "yes" if value else "no"
    value = shown_value(value, unit)
    return f"{value:.1f}" if abs(value) >= 100.0 else f"{value:.3g}"
