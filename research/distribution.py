"""Measures how long a behavior takes from one agent to a thousand others, while they act.

All are in a few host processes and act in real time at 10 Hz. One of them has learned a behavior
of four automata and gives it to all others. Measured are the time until the last agent has
acknowledged that the behavior is in its library and in its memory, and the longest time between
two actions of a host.

    scripts/python research/distribution.py --agents 1000 --hosts 2
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import psutil  # type: ignore[import-untyped]
import typer
from rich.console import Console
from rich.table import Table

SOURCE = "ant_1"
WARM_UP_S = 5.0
TIMEOUT_S = 60.0


@dataclass(frozen=True)
class Figures:
    """What was measured of one swarm; all times in ms.

    Attributes:
        acked: from the request until the last acknowledgement arrived, per distribution.
        gap_before: the longest time between two answers of a host, without a distribution.
        gap: the same during a distribution.
        late: actions that had not arrived when their cycle ended, during the distributions.
        refused: the agents that refused it.
    """

    libraries: str
    receivers: int
    acked: list[float]
    gap_before: float
    gap: float
    late: int
    refused: int


def description(agents: int, hosts: int, library: str) -> str:
    """Return the description of a swarm of agents without commanders."""
    return "\n".join(
        [
            "swarm: distribution",
            "domain: plain_world:DOMAIN",
            "behavior: Explore",
            f"hosts: {hosts}",
            *([f"library: '{library}'"] if library else []),
            f"world: {{kind: plain, module: plain_world, parameters: {{agents: {agents}}}}}",
            "agents:",
            f"  ant: {{count: {agents}}}",
            "",
        ]
    )


def teach(folder: Path, version: int) -> None:
    """Put a behavior of four automata into a library, a little different in each version."""
    from plain_world import DOMAIN

    from hitab_core.agent import Agent
    from hitab_core.library.behavior_library import BehaviorLibrary
    from hitab_core.term import Term
    from hitab_core.training import Curriculum

    teacher = Agent("teacher", DOMAIN, BehaviorLibrary(folder, DOMAIN))
    for name, states in (
        ("Circle", ("Walk", "Turn")),
        ("Pause", ("Wait", "Walk")),
        ("Search", ("Circle", "Pause")),
        ("Expedition", ("Search", "Wait")),
    ):
        teacher.begin(Curriculum(name, (Term("X"), Term("Y"), Term("Heading"))), discard=True)
        for number in range(12):
            teacher.sense([(7.0 * number) % 5 + version, float(number), number / 4 - 1.5], [])
            teacher.command(Term(states[number % 2]))
        teacher.save()


class Meter:
    """Hears acknowledgements and actions, and asks for distributions."""

    def __init__(self, link: Any, agents: int) -> None:
        from hitab_msgs import msg, srv

        from hitab_core.operations import Distribute, LoadLibrary
        from hitab_ros import names, qos
        from hitab_ros.names import WORLD

        self._link = link
        self._load, self._distribute = srv.LoadLibrary, srv.Distribute
        node = link.node
        self._loader = node.create_client(srv.LoadLibrary, f"/{SOURCE}/{LoadLibrary.name}")
        self._asker = node.create_client(srv.Distribute, f"/{SOURCE}/{Distribute.name}")
        self._receivers = [f"ant_{i + 1}" for i in range(agents) if f"ant_{i + 1}" != SOURCE]
        self._acks: dict[int, dict[str, tuple[float, bool]]] = defaultdict(dict)
        self.answers: dict[str, list[float]] = defaultdict(list)
        self.late = 0
        node.create_subscription(
            msg.DistributionAck, f"/{names.DISTRIBUTION_ACK}", self._on_ack, qos.ROLL_CALL
        )
        node.create_subscription(
            msg.ActionBatch, f"/{WORLD}/{names.ACTION_BATCHES}", self._on_actions, qos.CYCLE
        )
        node.create_subscription(
            msg.WorldStatus, f"/{WORLD}/{names.STATUS}", self._on_world, qos.LATCHED
        )

    def _on_ack(self, ack: Any) -> None:
        self._acks[ack.sequence][ack.agent] = (time.perf_counter(), ack.success)

    def _on_actions(self, actions: Any) -> None:
        self.answers[actions.host].append(time.perf_counter())

    def _on_world(self, status: Any) -> None:
        self.late = status.missed_deadlines

    def ready(self, timeout_s: float) -> bool:
        """Wait for the source's services."""
        link = self._link
        return bool(
            link.spin_until(self._loader.service_is_ready, timeout_s)
            and link.spin_until(self._asker.service_is_ready, timeout_s)
        )

    def wait(self, seconds: float) -> None:
        """Receive what arrives."""
        self._link.spin_until(lambda: False, seconds)

    def load(self, folder: Path) -> None:
        """Have the source learn what is in a library."""
        future = self._loader.call_async(self._load.Request(path=str(folder)))
        if not self._link.spin_until(future.done, TIMEOUT_S) or not future.result().success:
            raise SystemExit(f"the source does not load {folder}: {future.result()}")

    def distribute(self) -> tuple[float, int]:
        """Give it to all; return the time until the last acknowledgement, s, and the refusals."""
        began = time.perf_counter()
        future = self._asker.call_async(
            self._distribute.Request(behavior="Expedition", receivers=self._receivers)
        )
        if not self._link.spin_until(future.done, TIMEOUT_S) or not future.result().success:
            raise SystemExit(f"the source does not distribute: {future.result()}")
        acks = self._acks[future.result().sequence]
        self._link.spin_until(lambda: len(acks) == len(self._receivers), TIMEOUT_S)
        if len(acks) < len(self._receivers):
            return float("inf"), len(self._receivers) - len(acks)
        last = max(at for at, _ in acks.values())
        return last - began, sum(not success for _, success in acks.values())

    def worst_gap(self, begin: float, end: float) -> float:
        """Return the longest time between two answers of a host in a time, s."""
        return max(
            (
                after - before
                for times in self.answers.values()
                for before, after in pairwise(times)
                if after > begin and before < end
            ),
            default=float("inf"),
        )


def hurry(folder: Path) -> None:
    """Give the processes of the swarm, and this one, priority over other work on this machine."""
    for process in psutil.process_iter(["cmdline"]):
        line = " ".join(process.info["cmdline"] or ())
        if str(folder) in line or "plain_world" in line or process.pid == os.getpid():
            for thread in process.threads():
                os.sched_setscheduler(thread.id, os.SCHED_RR, os.sched_param(1))


def measure(agents: int, hosts: int, library: str, rounds: int, *, preferred: bool) -> Figures:
    """Bring a swarm up, distribute a few times, take it down."""
    from hitab_bringup.processes import supervision
    from hitab_bringup.processes.bringing_up import bring_up
    from hitab_bringup.swarm_files.swarm_file import parse_swarm
    from hitab_client import domain_ids
    from hitab_client.connecting.ros_link import RosLink
    from hitab_client.runs.run_folder import RunFolder

    with tempfile.TemporaryDirectory(prefix="hitab-give-") as place, domain_ids.reserved() as id_:
        folder = Path(place).resolve()
        os.environ["ROS_DOMAIN_ID"] = str(id_)
        own = str(folder / "own" / library) if library else ""
        swarm = parse_swarm(description(agents + 1, hosts, own), folder / "give.yaml")
        swarm = replace(swarm, name=f"distribution_{os.getpid()}")
        run_folder = RunFolder(folder)
        bring_up(swarm, run_folder)
        try:
            if preferred:
                hurry(folder)
            with RosLink(id_) as link:
                meter = Meter(link, agents + 1)
                if not meter.ready(30.0 + 0.05 * agents):
                    raise SystemExit("the services of the source do not answer")
                meter.wait(WARM_UP_S)
                began = time.perf_counter()
                meter.wait(WARM_UP_S)
                gap_before = meter.worst_gap(began, time.perf_counter())
                acked, gaps, refused, late = [], [], 0, meter.late
                for version in range(rounds):
                    lesson = folder / f"lesson_{version}"
                    teach(lesson, version)
                    meter.load(lesson)
                    meter.wait(1.0)
                    began = time.perf_counter()
                    seconds, failed = meter.distribute()
                    refused += failed
                    acked.append(seconds * 1000)
                    meter.wait(3.0)  # what is done after the acknowledgements counts, too
                    gaps.append(meter.worst_gap(began, time.perf_counter()) * 1000)
                return Figures(
                    "one each" if library else "one a host",
                    agents,
                    acked,
                    gap_before * 1000,
                    max(gaps),
                    meter.late - late,
                    refused,
                )
        finally:
            supervision.stop(run_folder)


def show(results: list[Figures], hosts: int) -> None:
    """Print a table."""
    table = Table(
        title=f"One agent gives a behavior of four automata to all others, {hosts} hosts"
    )
    for title in ("libraries", "receivers", "first ms", "median ms", "worst ms"):
        table.add_column(title, justify="right")
    for title in ("gap before ms", "gap ms", "late answers", "refused"):
        table.add_column(title, justify="right")
    for f in results:
        table.add_row(
            f.libraries,
            f"{f.receivers:,}",
            *(f"{x:,.0f}" for x in (f.acked[0], median(f.acked), max(f.acked))),
            f"{f.gap_before:.0f}",
            f"{f.gap:.0f}",
            f"{f.late:,}",
            f"{f.refused:,}",
        )
    Console(width=120).print(table)


def main(
    agents: Annotated[int, typer.Option(help="Number of receivers.")] = 1000,
    hosts: Annotated[int, typer.Option(help="Processes that run the agents.")] = 2,
    rounds: Annotated[int, typer.Option(help="Distributions, each of a new version.")] = 5,
    preferred: Annotated[
        bool,
        typer.Option(help="Raise the priority of the swarm's processes; needs privileges."),
    ] = False,
) -> None:
    """Measure how a behavior spreads."""
    here = str(Path(__file__).resolve().parent)
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (here, os.environ.get("PYTHONPATH"))))
    results = []
    for library in ("", "{agent}"):
        results.append(measure(agents, hosts, library, rounds, preferred=preferred))
        show(results, hosts)


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    typer.run(main)
