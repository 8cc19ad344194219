"""What is wrong with an agent, for the topic ``/diagnostics``."""

from __future__ import annotations

from collections.abc import Sequence

from hitab_agent.guarded_tick import FEATURES, TICK, VALUES
from hitab_agent.status_publisher import StatusPublisher
from hitab_core import Agent
from hitab_ros import Guard
from hitab_ros.diagnostics import Diagnosis, Level

MILD = (FEATURES, VALUES, "action ")
"""How the keys of faults begin with which an agent still acts; with others it may not."""


def diagnosis_of_agent(
    agent: Agent,
    guard: Guard,
    status: StatusPublisher,
    hardware: str,
    more: Sequence[tuple[Level, str]] = (),
) -> Diagnosis:
    """Return what is wrong with an agent.

    Args:
        agent: the agent.
        guard: of its node; its faults are shown.
        status: of the agent.
        hardware: the agent's namespace, which is unique.
        more: what else is wrong.
    """
    found = [*more]
    for key, text in guard.faults.by_key.items():
        found.append((Level.WARN if key.startswith(MILD) else Level.ERROR, text))
    if status.refusal:
        found.append((Level.WARN, status.refusal))
    if agent.monitor.unsure:
        found.append((Level.WARN, f"unsure: {agent.monitor.unsure}"))
    if status.notice:
        found.append((Level.WARN, status.notice))
    found += [(Level.WARN, text) for text in (*agent.faults, *agent.repertoire.vacancies)]
    if not agent.context.senses.perceived and TICK not in guard.faults.by_key:
        found.append((Level.STALE, "nothing perceived yet: no sensors, and no world"))

    def details() -> tuple[str, dict[str, object]]:
        behavior = f' "{agent.behavior}"' if agent.behavior else ""
        values = {
            "mode": agent.mode,
            "behavior": agent.behavior,
            "active states": "/".join(agent.active_path),
            "cycle": agent.cycle,
            "domain": agent.domain.name,
            "library": agent.edition.digest,
        }
        return f"{agent.mode}{behavior}", values

    return Diagnosis(agent.name, hardware, found, details)
