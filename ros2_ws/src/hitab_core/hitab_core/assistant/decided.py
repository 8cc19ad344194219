"""Distances of the decisions that an agent has made, for those who watch many agents.

Only values that the decisions have read are used, and nothing is read: watching changes nothing.
"""

from __future__ import annotations

from hitab_core.advice.confidence import RatedFunctions
from hitab_core.domain import Domain
from hitab_core.running.run_context import Running
from hitab_core.running.running_automaton import RunningAutomaton


def decided_at(running: Running | None, domain: Domain, rated: RatedFunctions) -> float:
    """Return the distance of the last tick's decisions from their examples, in spreads.

    It is the largest of all levels; 0 where none was made, or the active state was entered.

    Args:
        running: the performed behavior; None if there is none.
        domain: domain of the agent.
        rated: confidences of learned functions, which agents that share behaviors may share.
    """
    farthest = 0.0
    while isinstance(running, RunningAutomaton):
        function, automaton = running.function, running.automaton
        if function is not None and automaton.examples:
            one = rated.of(
                function, running.active, automaton.features, automaton.examples, domain
            )
            distance = one.decided(running.vector.known())
            if distance > farthest:
                farthest = distance
        running = running.child
    return farthest
