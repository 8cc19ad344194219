"""A swarm whose processes are killed at random ends as one that nobody disturbs.

``HITAB_CHAOS_KILLS=200 HITAB_CHAOS_SEED=3`` plays a longer run, or another one.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import random
import signal
from collections.abc import Iterator
from pathlib import Path

import chaos_domain
import pytest

from hitab_bringup.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_file import parse_swarm
from hitab_client.errors import SwarmError
from hitab_client.run_processes import process_states

KILLS = int(os.environ.get("HITAB_CHAOS_KILLS", "20"))
SEED = int(os.environ.get("HITAB_CHAOS_SEED", "1"))
SECONDS = 60.0
WORKERS, PROCESSES = 9, 7
COMMANDERS = ("chief", "squad_1", "squad_2", "squad_3")

SWARM = """\
swarm: chaos
domain: chaos_domain:DOMAIN
start_from: library
world: {kind: chaos, module: chaos_domain, parameters: {workers: 9}}
agents:
  worker_1: {host: hostel_1}
  worker_2: {host: hostel_1}
  worker_3: {host: hostel_1}
  worker_4: {host: hostel_2}
  worker_5: {host: hostel_2}
  worker_6: {host: hostel_2}
  worker_7: {}
  worker_8: {}
  worker_9: {host: hostel_2}
kinds:
  Squad: {orders: {Dig: Digging, Haul: Hauling, Rest: Resting}}
  Chief: {orders: {Dig: Dig, Haul: Haul, Rest: Rest}}
commanders:
  squad_1: {kind: Squad, commands: [worker_1, worker_2, worker_3], host: hostel_1}
  squad_2: {kind: Squad, commands: [worker_4, worker_5, worker_6]}
  squad_3: {kind: Squad, commands: [worker_7, worker_8, worker_9]}
  chief: {kind: Chief, commands: [squad_1, squad_2, squad_3]}
"""
MEANT = {"Dig": "Digging", "Haul": "Hauling", "Rest": "Resting"}

State = dict[str, tuple[str, str, str]]


class Swarm:
    """The swarm, the orders that it was given, and what its workers have begun.

    Attributes:
        orders: in order, one only once if it was given again at once.
        acknowledged: how often the chief has said that it obeys.
    """

    def __init__(self, running: RunningSwarm, folder: Path) -> None:
        self.running = running
        self.folder = folder
        self.orders: list[str] = []
        self.acknowledged = 0

    def give(self, order: str, *, insist: bool) -> None:
        """Have the chief order something; it may be obeyed although nobody answers."""
        if self.orders[-1:] != [order]:
            self.orders.append(order)
        while True:
            try:
                self.running.agents.perform("chief", order)
            except SwarmError:
                if not insist:
                    return
            else:
                self.acknowledged += 1
                return

    def state(self) -> State:
        """Return what each member does: mode, behavior, digest of what it has learned."""
        statuses = self.running.agents.statuses
        return {n: (s.mode, s.behavior, s.library_digest) for n, s in statuses.items()}

    def obeys(self) -> bool:
        """Whether all do what was ordered last."""
        order, state = self.orders[-1], self.state()
        wanted = dict.fromkeys(COMMANDERS, order)
        wanted |= {f"worker_{i + 1}": MEANT[order] for i in range(WORKERS)}
        return {name: behavior for name, (_, behavior, _) in state.items()} == wanted

    def until_all_obey(self) -> None:
        """Wait until all do what was ordered last, and their bodies have begun to."""
        basic = chaos_domain.TRAINED[MEANT[self.orders[-1]]]

        def begun() -> bool:
            return self.obeys() and all(
                lives[-1][-1:] == [basic] for lives in self.begun().values()
            )

        assert self.running.link.spin_until(begun, SECONDS, 0.05), (
            f"ordered {self.orders[-1]}, but {self.state()}"
        )

    def begun(self) -> dict[str, list[list[str]]]:
        """Return the basic behaviors that each worker has begun, in each life of its process."""
        found = {}
        for log in self.folder.glob("*.log"):
            lines = [line.split() for line in log.read_text().splitlines()]
            groups = itertools.groupby(lines, key=lambda line: line[0])
            found[log.stem] = [[basic for _, basic in group] for _, group in groups]
        return found

    def kill(self, choose: random.Random) -> str:
        """Kill a process that has been up for a while, other than the world; return its name.

        Half of them are left in peace at any time.
        """
        pids: dict[str, int] = {}

        def enough() -> bool:
            pids.clear()
            for state in process_states(self.running.record):
                if state["statename"] == "RUNNING" and state["name"] != "world":
                    pids[state["name"]] = state["pid"]
            return len(pids) > PROCESSES // 2

        assert self.running.link.spin_until(enough, SECONDS, 0.05)
        name, pid = choose.choice(sorted(pids.items()))
        with contextlib.suppress(ProcessLookupError):  # it has ended by itself
            os.kill(pid, signal.SIGKILL)
        return name


@pytest.fixture
def swarm(tmp_path: Path, home: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Swarm]:
    """Return a swarm of nine workers under four commanders, in seven processes and a world."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    monkeypatch.setenv("CHAOS_FOLDER", str(tmp_path))
    chaos_domain.make_library(tmp_path / "library")
    description = parse_swarm(SWARM, tmp_path / "chaos.yaml")
    with temporary_swarm(description, tmp_path / "run") as running:
        yield Swarm(running, tmp_path)


def is_part_of(begun: list[str], orders: list[str]) -> bool:
    """Whether what was begun was ordered in this order, perhaps with orders left out."""
    remaining = iter(orders)
    return all(basic in remaining for basic in begun)


@pytest.mark.long
def test_a_swarm_survives_being_killed_at_random(swarm: Swarm) -> None:
    choose = random.Random(SEED)
    for order in MEANT:
        swarm.give(order, insist=True)
        swarm.until_all_obey()
    undisturbed = swarm.state()

    killed: list[str] = []
    for _ in range(KILLS):
        killed.append(swarm.kill(choose))
        if choose.random() < 0.5 and "chief" not in killed[-2:]:
            swarm.give(choose.choice([o for o in MEANT if o != swarm.orders[-1]]), insist=False)
    in_between = swarm.acknowledged - len(MEANT)
    swarm.give("Rest", insist=True)
    swarm.until_all_obey()

    assert len(swarm.orders) > 5
    assert in_between > 0
    assert swarm.state() == undisturbed
    ordered = [chaos_domain.TRAINED[MEANT[order]] for order in swarm.orders]
    begun_by = swarm.begun()
    assert len(begun_by) == WORKERS
    for worker, lives in begun_by.items():
        assert lives[0], f"{worker} has begun nothing"
        for begun in lives:
            # Each was begun once for each order, though some were overtaken by the next.
            assert is_part_of(begun, ordered), f"{worker} began {begun} of {ordered}; {killed}"
