"""Where a trained automaton decides otherwise than was intended.

An intention plays itself for some games; each decision of its plans is kept, with what was seen.
A trained automaton is then asked for the same decisions. Decisions are grouped by state and by
what was intended, so that the answer names what went wrong, such as ``Stop -> Pass``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from intentions import INTENTIONS, Edges, Plan, Seen

from hitab_core import Automaton, Repertoire
from hitab_world.inprocess import perform, play
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld

Decision = tuple[str, str]
"""A state, and the state that was intended to follow."""

GAMES = 12
MOST = 200
"""The most decisions of one kind that are looked at."""

Records = Mapping[str, Mapping[Decision, list[tuple[float, ...]]]]
"""The values seen at each kind of decision, by plan."""


@cache
def decisions(intention: str, seed: int) -> Records:
    """Return the decisions of an intention that plays itself."""
    found: dict[str, dict[Decision, list[tuple[float, ...]]]] = {}

    def noting(plan: Plan) -> Plan:
        kinds: dict[Decision, list[tuple[float, ...]]] = found.setdefault(
            plan.name, defaultdict(list)
        )

        def rule(state: str, seen: Seen, edges: Edges) -> str:
            wished = plan.rule(state, seen, edges)
            values = kinds[state, wished]
            if len(values) < MOST:
                values.append(tuple(seen[f] for f in plan.features))
            return wished

        return replace(plan, rule=rule)

    plans = [noting(plan) for plan in INTENTIONS[intention].plans]
    world = KeepawayWorld(seed=seed)
    automata = {plan.name: plan.automaton() for plan in plans}
    play(world, perform(world, Repertoire(DOMAIN, automata), plans[-1].name), GAMES, first=0)
    return found


def objections(
    plan: Plan, trained: Automaton, records: Mapping[Decision, list[tuple[float, ...]]]
) -> dict[str, float]:
    """Return, for each kind of decision, the mean probability of what was not intended.

    What a person who wavers might also do is no objection.
    """
    names = [str(feature) for feature in trained.features]
    found: dict[str, float] = {}
    for (state, wished), all_values in records.items():
        function: Any = trained.transitions.get(state)
        wrong = 0.0
        for values in all_values:
            seen = dict(zip(plan.features, values, strict=True))
            fits = plan.fitting(state, seen)
            if function is None:
                wrong += state not in fits
                continue
            spread = function.explain([seen[name] for name in names], names).distribution
            wrong += sum(p for label, p in spread.items() if label not in fits)
        found[f"{state} -> {wished}" if state != wished else f"{state} stays"] = wrong / len(
            all_values
        )
    return found
