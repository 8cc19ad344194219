"""Measures what the failure of one host costs all others, in real time.

A thousand agents under a tree of commanders play in four hosts. One host, without the root
commander, is killed, stopped for a while, or starved by busy loops on its core. Half a second
later the root gets another order.

    scripts/python research/host_restart.py --failures kill:0,stop:3,stop:40,starve:10
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import psutil  # type: ignore[import-untyped]
import typer

from swarms import ORDERS, description

BEFORE_S, ORDER_AFTER_S, CALM_S, OVER_MAX_S, LOOK_S = 8, 0.5, 6.0, 120.0, 0.05
FORGOTTEN_S = 24.0  # after which others have dropped a process that has died
BUSY_LOOPS = 4
NEVER = float("inf")


class Answers:
    """Cycles and late answers of each host by the second, as an observer sees them.

    An answer is late if the percepts of the next cycle come before it.

    Attributes:
        agents: the agents of each host.
        rosters: number of the roster to which each host's last answer referred, and since when.
    """

    def __init__(self, link: Any) -> None:
        from hitab_msgs import msg

        from hitab_ros import HostRosters, names, qos

        self.agents: dict[str, list[str]] = {}
        self.rosters: dict[str, tuple[int, float]] = {}
        self._began = 0.0
        self._cycles: Counter[int] = Counter()
        self._late: Counter[tuple[str, int]] = Counter()
        self._sequence = 0
        self._answered: set[str] = set()
        create = link.node.create_subscription

        def on_roster(roster: Any) -> None:
            if roster.host not in self.agents:
                topic = f"/{roster.host}/{names.PERCEPTS}"
                create(msg.PerceptBatch, topic, self._on_percepts, qos.ROLL_CALL)
            self.agents[roster.host] = [n for n in roster.agents if n.startswith("ant_")]

        HostRosters(link.node, f"/{names.HOSTS}").changed.append(on_roster)
        topic = f"/{names.WORLD}/{names.ACTION_BATCHES}"
        create(msg.ActionBatch, topic, self._on_actions, qos.ROLL_CALL)

    def begin(self) -> None:
        """Begin to count; the failure is due after a while."""
        self._began = time.monotonic() + BEFORE_S
        self._cycles.clear()
        self._late.clear()

    @property
    def now(self) -> float:
        """Time since the failure, s."""
        return time.monotonic() - self._began

    def _on_percepts(self, batch: Any) -> None:
        if batch.sequence > self._sequence:
            second = int(self.now // 1)
            self._cycles[second] += 1
            for host, agents in self.agents.items():
                self._late[host, second] += len(agents) * (host not in self._answered)
            self._sequence, self._answered = batch.sequence, set()

    def _on_actions(self, batch: Any) -> None:
        if batch.sequence == self._sequence:
            self._answered.add(batch.host)
        if self.rosters.get(batch.host, (0, 0.0))[0] != batch.roster:
            self.rosters[batch.host] = batch.roster, self.now

    def late(self, hosts: set[str], begin: int, end: int) -> float:
        """Return the share of late answers of some hosts in some seconds."""
        seconds = range(begin, end)
        due = sum(len(self.agents[h]) for h in hosts) * sum(self._cycles[s] for s in seconds)
        return sum(self._late[h, s] for h in hosts for s in seconds) / due if due else 0.0

    def cycles(self, begin: int, end: int) -> int:
        """Return the number of cycles in some seconds."""
        return sum(self._cycles[s] for s in range(begin, end))


@contextmanager
def failure(kind: str, process: psutil.Process) -> Iterator[None]:
    """Kill, stop or starve a process; the end of the context ends the latter two."""
    loops: list[subprocess.Popen[bytes]] = []
    if kind == "starve":
        core = sorted(os.sched_getaffinity(0))[:1]
        for thread in process.threads():
            os.sched_setaffinity(thread.id, core)
        loop = ["nice", "-n", "-5", "taskset", "-c", str(core[0]), sys.executable, "-c"]
        loops += [subprocess.Popen([*loop, "while True: pass"]) for _ in range(BUSY_LOOPS)]
    else:
        process.send_signal(signal.SIGKILL if kind == "kill" else signal.SIGSTOP)
    try:
        yield
    finally:
        for running in loops:
            running.kill()
            running.wait()
        if kind == "stop":
            process.send_signal(signal.SIGCONT)


def measure(running: Any, answers: Answers, kind: str, lasts_s: float, order: str) -> str:
    """Let a host fail; return what came of it."""
    from hitab_client.runs.run_processes import process_states
    from hitab_core.operations import Perform

    link, statuses, groups = running.link, running.agents.statuses, running.groups
    name, members = next(
        (name, members)
        for name, members in running.record.processes.items()
        if len(members) > 1 and "root" not in members
    )
    failed = next(h for h, agents in answers.agents.items() if set(agents) <= set(members))
    others = answers.agents.keys() - {failed}
    (pid,) = (s["pid"] for s in process_states(running.record) if s["name"] == name)
    answers.begin()
    link.spin_until(lambda: answers.now >= 0.0, BEFORE_S + 1.0, LOOK_S)
    roster, _ = answers.rosters[failed]
    times = {"others obey": NEVER, "acts again": NEVER, "obeys": NEVER, "none silent": NEVER}
    most_silent, ordered = 0, False

    def keep(what: str, *, holds: bool) -> None:
        times[what] = min(times[what], answers.now) if holds else NEVER

    def obey(hosts: set[str]) -> bool:
        return all(
            a in statuses and statuses[a].behavior == order
            for host in hosts
            for a in answers.agents[host]
        )

    def look() -> bool:
        nonlocal most_silent, ordered
        if not ordered and answers.now >= ORDER_AFTER_S:
            ordered = True
            running.agents.do("root", Perform(order))
        most_silent = max(most_silent, len(groups.incomplete))
        keep("others obey", holds=obey(others))
        keep("obeys", holds=obey({failed}))
        keep("none silent", holds=not groups.incomplete)
        number, since = answers.rosters[failed]
        times["acts again"] = since if number != roster else NEVER
        needed = {**times, "acts again": 0.0} if number == roster else times
        return answers.now > max(lasts_s, FORGOTTEN_S, *needed.values()) + CALM_S

    with failure(kind, psutil.Process(pid)):
        link.spin_until(lambda: bool(look() or answers.now >= lasts_s), OVER_MAX_S, LOOK_S)
    link.spin_until(look, OVER_MAX_S, LOOK_S)
    seconds = range(int(answers.now))
    worst = max(seconds, key=lambda s: answers.late(others, s, s + 2))
    return (
        f"{kind}:{lasts_s:g} late of the others: before {answers.late(others, -BEFORE_S, 0):.2%}, "
        f"in the first 2 s {answers.late(others, 0, 2):.2%}, in the worst 2 s "
        f"{answers.late(others, worst, worst + 2):.2%} (from {worst}); fewest cycles in a second "
        f"{min(answers.cycles(s, s + 1) for s in seconds)}; groups with silent members at most "
        f"{most_silent}; s: " + ", ".join(f"{what} {at:.1f}" for what, at in times.items())
    )


def main(
    failures: Annotated[
        str, typer.Option(help="Kinds of failures, each with its duration, s.")
    ] = "kill:0,stop:3,stop:40,starve:10",
    agents: Annotated[int, typer.Option(help="Number of agents.")] = 1000,
    hosts: Annotated[int, typer.Option(help="Number of hosts.")] = 4,
) -> None:
    """Measure what the failure of a host costs."""
    from hitab_bringup.processes.bringing_up import temporary_swarm
    from hitab_bringup.swarm_files.swarm_file import parse_swarm

    here = str(Path(__file__).resolve().parent)
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (here, os.environ.get("PYTHONPATH"))))
    with tempfile.TemporaryDirectory(prefix="hitab-restart-") as place:
        swarm = parse_swarm(description(agents, hosts), Path(place) / "scale.yaml")
        with temporary_swarm(swarm, Path(place) / "run") as running:
            answers = Answers(running.link)
            running.link.spin_until(
                lambda: len(answers.agents.keys() & answers.rosters) == hosts, 30.0, LOOK_S
            )
            for number, text in enumerate(failures.split(",")):
                kind, _, lasts_s = text.partition(":")
                order = ORDERS[(number + 1) % len(ORDERS)]
                typer.echo(measure(running, answers, kind, float(lasts_s), order))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    typer.run(main)
