"""A swarm whose processes are killed at random ends as one that nobody disturbs."""

from __future__ import annotations

import contextlib
import os
import random
import signal
from pathlib import Path

import pytest

from hitab_bringup import RunningSwarm, parse_swarm, temporary_swarm
from hitab_client import SwarmError
from hitab_client.runs.run_processes import process_states
from hitab_core.operations import Perform

KILLS, SEED = 20, 1
SECONDS = 60.0
PROCESSES = 7
SWARM = """\
swarm: chaos
domain: foraging
world: {kind: foraging, pace: realtime, parameters: {foragers: 9}}
agents:
  forager_1: {host: hostel_1}
  forager_2: {host: hostel_1}
  forager_3: {host: hostel_1}
  forager_4: {host: hostel_2}
  forager_5: {host: hostel_2}
  forager_6: {host: hostel_2}
  forager_7: {}
  forager_8: {}
  forager_9: {host: hostel_2}
kinds:
  Squad: {orders: {Explore: Forward, Turn: RotateLeft, Rest: Stop}}
  Chief: {orders: {Explore: Explore, Turn: Turn, Rest: Rest}}
commanders:
  squad_1: {kind: Squad, commands: [forager_1, forager_2, forager_3], host: hostel_1}
  squad_2: {kind: Squad, commands: [forager_4, forager_5, forager_6]}
  squad_3: {kind: Squad, commands: [forager_7, forager_8, forager_9]}
  chief: {kind: Chief, commands: [squad_1, squad_2, squad_3]}
"""
MEANT = {"Explore": "Forward", "Turn": "RotateLeft", "Rest": "Stop"}


def states(swarm: RunningSwarm) -> dict[str, tuple[str, str, str]]:
    """Return what each member does: mode, behavior, digest of what it has learned."""
    statuses = swarm.agents.statuses
    return {n: (s.mode, s.behavior, s.library_digest) for n, s in statuses.items()}


def until_all_obey(swarm: RunningSwarm, order: str) -> None:
    def obeyed() -> bool:
        return all(
            behavior == (MEANT[order] if name.startswith("forager") else order)
            for name, (_, behavior, _) in states(swarm).items()
        )

    assert swarm.link.spin_until(obeyed, SECONDS, 0.05), f"ordered {order}, but {states(swarm)}"


def kill(swarm: RunningSwarm, choose: random.Random) -> str:
    """Kill a process other than the world; half of them are left in peace at any time."""
    pids: dict[str, int] = {}

    def enough() -> bool:
        pids.clear()
        for state in process_states(swarm.record):
            if state["statename"] == "RUNNING" and state["name"] != "world":
                pids[state["name"]] = state["pid"]
        return len(pids) > PROCESSES // 2

    assert swarm.link.spin_until(enough, SECONDS, 0.05)
    name, pid = choose.choice(sorted(pids.items()))
    with contextlib.suppress(ProcessLookupError):  # it has ended by itself
        os.kill(pid, signal.SIGKILL)
    return name


@pytest.mark.long
def test_a_swarm_survives_being_killed_at_random(home: Path, tmp_path: Path) -> None:
    choose, killed, acknowledged = random.Random(SEED), list[str](), 0
    with temporary_swarm(parse_swarm(SWARM, tmp_path / "chaos.yaml"), tmp_path / "run") as swarm:
        for order in MEANT:
            swarm.agents.do("chief", Perform(order))
            until_all_obey(swarm, order)
        undisturbed = states(swarm)
        for _ in range(KILLS):
            killed.append(kill(swarm, choose))
            if choose.random() < 0.5 and "chief" not in killed[-2:]:
                with contextlib.suppress(SwarmError):  # it may be obeyed although nobody answers
                    swarm.agents.do("chief", Perform(choose.choice(list(MEANT))))
                    acknowledged += 1
        while True:
            with contextlib.suppress(SwarmError):
                swarm.agents.do("chief", Perform("Rest"))
                break
        assert acknowledged > 0
        until_all_obey(swarm, "Rest")
        assert states(swarm) == undisturbed
