"""The faults of a world, for the topic ``/diagnostics``."""

from __future__ import annotations

from hitab_core import some
from hitab_ros import Guard
from hitab_ros.nodes.diagnostics import Diagnosis, Level
from hitab_world.simulating.run_state import RunState

NAMED_MAX = 10  # maximum number of agents that a message names


def diagnosis_of_world(
    run_state: RunState, guard: Guard, hardware: str, errors: set[str]
) -> Diagnosis:
    """Return the faults of a world.

    Args:
        run_state: the world's run state.
        guard: the guard of the world's node, whose faults are shown.
        hardware: the world's namespace, which is unique.
        errors: the keys of faults with which the world cannot continue.
    """
    world, control, round_answers = run_state.world, run_state.control, run_state.round_answers
    found = [
        (Level.ERROR if key in errors else Level.WARN, text)
        for key, text in guard.faults.by_key.items()
    ]
    missing = round_answers.missing
    if missing:
        found.append((Level.WARN, f"no node answers for {some(missing, NAMED_MAX)}"))

    def details() -> tuple[str, dict[str, object]]:
        mode = "paused" if control.at_rest else "running"
        values = {
            "mode": mode,
            "pace": control.pace,
            "factor": control.factor,
            "cycle": world.cycle,
            "agents": len(world.agents),
            "missing agents": len(missing),
            "missed deadlines": round_answers.missed_deadlines,
            "reproducible": run_state.reproducible,
        }
        return mode, values

    return Diagnosis(world.name, hardware, found, details)
