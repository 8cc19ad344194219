"""What other learners make of the commands that a simulated person gave.

The peers are those of the scoreboard. They learn from the person's commands as these stand in the
end, after all corrections: what the keeper could read in each situation, and the basic behavior
that the command made it perform. They know no hierarchy, so a command of an automaton counts as
one of the basic behavior with which that begins there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from peers import OPTIONS, Command, learn
from soccer_tasks import Keepaway
from tasks import Team

from hitab_core import START, Automaton, Use
from hitab_core.automaton import FLAGS

TASK = Keepaway()


def commands_of(automata: Mapping[str, Automaton]) -> list[Command]:
    """Return the commands that some automata were learned from, from the bottom up.

    Flags such as Done, which only automata have, are left out.
    """
    found = []
    for automaton in automata.values():
        for example in automaton.examples:
            if example.is_default:
                continue
            readings = dict(zip(automaton.features, example.features, strict=True))
            if example.readings:  # the answer to a question has none
                readings |= zip(automaton.readable, example.readings, strict=True)
            behavior = basic_behavior(example.next_state, automata, readings)
            if behavior:
                state = basic_behavior(example.state, automata, readings)
                words = tuple(readings.get(use, math.nan) for use in TASK.words)
                found.append(Command(words, state or START, behavior))
    return found


def basic_behavior(
    state: str, automata: Mapping[str, Automaton], readings: Mapping[Use, float]
) -> str:
    """Return the basic behavior with which a state begins in a situation; "" if with none."""
    while automaton := automata.get(Use.parse(state).name):
        function = automaton.transitions.get(START)
        if function is None:
            return ""
        values = [
            0.0 if use.name in FLAGS else readings.get(use, math.nan) for use in automaton.features
        ]
        found = function.explain(values, [str(use) for use in automaton.features]).distribution
        state = max(found, key=lambda label: found[label])
    return state if Use.parse(state).name in TASK.domain.behaviors else ""


def teams_of_peers(automata: Mapping[str, Automaton]) -> Iterator[tuple[str, Sequence[Team]]]:
    """Yield each peer's name and its teams, one for each setting that is worth trying."""
    commands = commands_of(automata)
    for name, settings in OPTIONS.items():
        policies = [learn(name, commands, options=o, **TASK.peer_settings) for o in settings]
        yield name, [TASK.with_policy(policy, len(commands)) for policy in policies]
