"""The faults of an agent, for the topic ``/diagnostics``."""

from __future__ import annotations

from hitab_agent.node.agent_base import AgentBase
from hitab_agent.node.guarded_tick import FEATURES_FAULT, TICK, VALUES
from hitab_ros.nodes.diagnostics import Diagnosis, Level

MILD_FAULTS = (FEATURES_FAULT, VALUES, "action ")
"""Prefixes of the keys of mild faults, with which an agent still acts; with others it may not."""


def diagnosis_of_agent(node: AgentBase) -> Diagnosis:
    """Return the faults of a node's agent."""
    agent, status, faults = node.agent, node.status, node.guard.faults.by_key
    found = [
        *node.troubles(),
        *(
            (Level.WARN if key.startswith(MILD_FAULTS) else Level.ERROR, faults[key])
            for key in faults
        ),
    ]
    unsure = f"unsure: {agent.monitor.unsure}" if agent.monitor.unsure else ""
    warnings = (status.refusal, unsure, status.notice, *agent.faults)
    found += [(Level.WARN, text) for text in warnings if text]
    if not agent.context.feature_cache.perceived and TICK not in faults:
        found.append((Level.STALE, "nothing perceived yet: no sensors, and no world"))

    def details() -> tuple[str, dict[str, object]]:
        behavior = f' "{agent.behavior}"' if agent.behavior else ""
        values = {
            "mode": agent.mode,
            "behavior": agent.behavior,
            "active states": "/".join(agent.active_path),
            "cycle": agent.cycle,
            "domain": agent.domain.name,
            "library": agent.loaded.digest,
        }
        return f"{agent.mode}{behavior}", values

    return Diagnosis(agent.name, node.get_namespace(), found, details)
