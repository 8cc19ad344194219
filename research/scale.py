"""Measures swarms from ten to thousands of agents under a tree of commanders, in real time.

Each agent and each commander is a ROS 2 node with its own automaton; a few host processes run
them all. While the swarm plays, an order is given to the commander at the root twice a second, and
the time until the last agent reports that it performs the order is measured; in a large swarm, the
last agent of 200 squads. Before, it plays without orders, and afterwards it is paused.

    scripts/python research/scale.py --sizes 10,100,1000 --json scale.json --plot scale.png
    scripts/python research/scale.py --sizes 5000 --factor 0.5    # at 5 Hz
"""

from __future__ import annotations

import json as json_module
import math
import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import psutil  # type: ignore[import-untyped]
import typer
from rich.console import Console
from rich.table import Table

from swarms import FAN_OUT, ORDERS, commanders, description, levels

SIZES = "10,30,100,300,1000,3000,5000"
CYCLES_HZ = 10.0
SQUADS_WATCHED = 200
UNWATCHED_S, PAUSED_S = 15.0, 10.0
WARM_UP_S = 5.0
ORDER_PERIOD_S = 0.5
ORDER_TIMEOUT_S = 5.0


@dataclass(frozen=True)
class Figures:
    """What was measured of a swarm of one size; CPU is in cores, memory in MB.

    Attributes:
        factor: of real time, in which a cycle lasts 100 ms.
        start_cpu_s: CPU time of all processes until the swarm is up, those of `hitab up` included.
        cpu_playing: of the hosts, while nobody gives orders.
        late_answers: actions that had not arrived when their cycle ended.
        behind: cycles that the world lost against the clock.
        order_ms_...: from the request to the root until the last agent's report arrived.
    """

    agents: int
    factor: float
    commanders: int
    hosts: int
    seconds: float
    start_s: float
    start_cpu_s: float
    cycles: int
    late_answers: int
    behind: int
    orders: int
    order_ms_median: float
    order_ms_p99: float
    order_ms_max: float
    cpu_world: float
    cpu_hosts: float
    cpu_playing: float
    cpu_paused: float
    memory_world: float
    memory_hosts: float

    @property
    def cycle_us(self) -> float:
        """CPU time of all hosts per agent and cycle, µs, without orders; commanders included."""
        return self.cpu_playing / self.agents / (CYCLES_HZ * self.factor) * 1e6

    @property
    def memory_per_agent(self) -> float:
        """Memory of all hosts per agent, MB, its share of commanders included."""
        return self.memory_hosts / self.agents


class Orders:
    """Gives orders to the root and records which agents perform them.

    Attributes:
        missing: agents whose reports do not show yet that they perform the last order.
        seen: from each status of the world: its time of arrival, the cycle, the late answers.
    """

    def __init__(self, link: Any, agents: int) -> None:
        from hitab_msgs import msg, srv

        from hitab_core.operations import Perform
        from hitab_ros import names, qos
        from hitab_ros.names import WORLD

        self._link = link
        self._kind = srv.Perform
        self.missing: set[str] = set()
        self.seen: list[tuple[float, int, int]] = []
        self._done: float | None = 0.0
        self._wanted = ""
        self._client = link.node.create_client(srv.Perform, f"/root/{Perform.name}")
        name, _, count = next(iter(levels(agents)))
        watched = range(0, count, math.ceil(count / SQUADS_WATCHED))
        for index in watched:
            leader = name if count == 1 else f"{name}_{index + 1}"
            link.node.create_subscription(
                msg.Reports, f"/{leader}/{names.REPORTS}", self._on_reports, qos.EVENTS
            )
        link.node.create_subscription(
            msg.WorldStatus, f"/{WORLD}/{names.STATUS}", self._on_world, qos.LATCHED
        )
        self._agents = {
            f"ant_{i + 1}"
            for index in watched
            for i in range(index * FAN_OUT, min(agents, (index + 1) * FAN_OUT))
        }

    def _on_reports(self, message: Any) -> None:
        for report in message.reports:
            if report.path and report.path[0] == self._wanted:
                self.missing.discard(report.agent)
        if not self.missing and self._done is None:
            self._done = time.perf_counter()

    def _on_world(self, status: Any) -> None:
        self.seen.append((time.perf_counter(), status.cycle, status.missed_deadlines))

    def ready(self, timeout_s: float) -> bool:
        """Wait for the root's services."""
        return bool(self._link.spin_until(self._client.service_is_ready, timeout_s))

    def give(self, order: str) -> float:
        """Give an order; return the time until the last agent reports that it performs it, s."""
        self._wanted, self.missing, self._done = order, set(self._agents), None
        began = time.perf_counter()
        self._client.call_async(self._kind.Request(behavior=order))
        self._link.spin_until(lambda: self._done is not None, ORDER_TIMEOUT_S)
        return float("inf") if self._done is None else self._done - began


def _percentile(values: list[float], share: float) -> float:
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def _processes(run_folder: Any) -> tuple[list[psutil.Process], list[psutil.Process]]:
    """Return the world's process and those of the hosts."""
    running = {process: process.cmdline() for process in run_folder.processes()}
    world = [process for process, line in running.items() if "plain_world" in line]
    return world, [process for process, line in running.items() if "hitab_agent.host_main" in line]


def _cpu(processes: list[psutil.Process]) -> float:
    return sum(sum(p.cpu_times()[:2]) for p in processes)


def _memory(processes: list[psutil.Process]) -> float:
    return sum(p.memory_full_info().pss for p in processes) / 1e6


def _hurry(processes: list[psutil.Process]) -> None:
    """Give processes priority over other work on this machine."""
    for process in processes:
        for thread in process.threads():
            os.sched_setscheduler(thread.id, os.SCHED_RR, os.sched_param(1))


def measure(agents: int, hosts: int, seconds: float, factor: float, *, preferred: bool) -> Figures:
    """Bring a swarm up, play it for a while, give orders, pause it, take it down."""
    from hitab_msgs.srv import Control

    from hitab_bringup.processes import supervision
    from hitab_bringup.processes.bringing_up import bring_up
    from hitab_bringup.swarm_files.swarm_file import parse_swarm
    from hitab_client import domain_ids
    from hitab_client.connecting.ros_link import RosLink
    from hitab_client.runs.run_folder import RunFolder
    from hitab_client.world_client import WorldClient

    with tempfile.TemporaryDirectory(prefix="hitab-scale-") as place, domain_ids.reserved() as id_:
        folder = Path(place).resolve()
        os.environ["ROS_DOMAIN_ID"] = str(id_)
        swarm = parse_swarm(description(agents, hosts, factor=factor), folder / "scale.yaml")
        swarm = replace(swarm, name=f"scale_{os.getpid()}")
        run_folder = RunFolder(folder)
        began, own = time.perf_counter(), sum(os.times()[:2])
        bring_up(swarm, run_folder)
        start_s, start_cpu_s = time.perf_counter() - began, sum(os.times()[:2]) - own
        try:
            world, host_processes = _processes(run_folder)
            start_cpu_s += _cpu(world) + _cpu(host_processes)
            if preferred:
                _hurry([*world, *host_processes, psutil.Process()])
            time.sleep(WARM_UP_S)
            playing = _cpu(host_processes)
            time.sleep(UNWATCHED_S)
            playing = (_cpu(host_processes) - playing) / UNWATCHED_S
            with RosLink(id_) as link:
                orders = Orders(link, agents)
                if not orders.ready(30.0 + 0.05 * agents):
                    raise SystemExit("the root's services do not answer")
                link.spin_until(lambda: False, WARM_UP_S)
                for order in ORDERS:
                    orders.give(order)
                cpu = _cpu(world), _cpu(host_processes)
                began = time.perf_counter()
                orders.seen.clear()
                taken: list[float] = []
                while time.perf_counter() - began < seconds:
                    taken.append(orders.give(ORDERS[len(taken) % len(ORDERS)]))
                    due = began + len(taken) * ORDER_PERIOD_S - time.perf_counter()
                    link.spin_until(lambda: False, max(due, 0.0))
                lasted = time.perf_counter() - began
                (first, cycle, late), (last, last_cycle, last_late) = (
                    orders.seen[0],
                    orders.seen[-1],
                )
                used = (_cpu(world) - cpu[0], _cpu(host_processes) - cpu[1])
                WorldClient(link).control(Control.Request.PAUSE)
                paused = _cpu(world) + _cpu(host_processes)
                time.sleep(PAUSED_S)
                paused = (_cpu(world) + _cpu(host_processes) - paused) / PAUSED_S
                return Figures(
                    agents,
                    factor,
                    commanders(agents),
                    hosts,
                    lasted,
                    start_s,
                    start_cpu_s,
                    last_cycle - cycle,
                    last_late - late,
                    max(0, round((last - first) * CYCLES_HZ * factor) - (last_cycle - cycle)),
                    len(taken),
                    median(taken) * 1000,
                    _percentile(taken, 0.99) * 1000,
                    max(taken) * 1000,
                    used[0] / lasted,
                    used[1] / lasted,
                    playing,
                    paused,
                    _memory(world),
                    _memory(host_processes),
                )
        finally:
            supervision.stop(run_folder)


def show(results: list[Figures]) -> None:
    """Print a table."""
    table = Table(title=f"Agents under commanders of {FAN_OUT}")
    columns: list[tuple[str, Callable[[Figures], str]]] = [
        ("agents", lambda f: f"{f.agents:,}"),
        ("hosts", lambda f: f"{f.hosts}"),
        ("com-\nmanders", lambda f: f"{f.commanders:,}"),
        ("start\ns", lambda f: f"{f.start_s:.1f}"),
        ("\nCPU s", lambda f: f"{f.start_cpu_s:.1f}"),
        ("Hz", lambda f: f"{CYCLES_HZ * f.factor:g}"),
        ("cycles\nlost", lambda f: f"{f.behind}"),
        ("late\nanswers", lambda f: f"{f.late_answers:,}"),
        ("order ms\nmedian", lambda f: f"{f.order_ms_median:.0f}"),
        ("\np99", lambda f: f"{f.order_ms_p99:.0f}"),
        ("cores\nworld", lambda f: f"{f.cpu_world:.2f}"),
        ("\nhosts", lambda f: f"{f.cpu_hosts:.2f}"),
        ("no\norders", lambda f: f"{f.cpu_playing:.2f}"),
        ("\npaused", lambda f: f"{f.cpu_paused:.2f}"),
        ("cycle\nµs", lambda f: f"{f.cycle_us:.0f}"),
        ("MB\nworld", lambda f: f"{f.memory_world:.0f}"),
        ("\nhosts", lambda f: f"{f.memory_hosts:.0f}"),
        ("\nagent", lambda f: f"{f.memory_per_agent:.2f}"),
    ]
    for title, _ in columns:
        table.add_column(title, justify="right")
    for figures in results:
        table.add_row(*(text(figures) for _, text in columns))
    Console(width=140).print(table)


def plot(results: list[Figures], path: Path) -> None:
    """Draw how latency, CPU and memory grow."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter, StrMethodFormatter

    figure = Figure(figsize=(12, 3.6), dpi=110, layout="tight")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 3)
    sizes = [f.agents for f in results]
    axes[0].plot(sizes, [f.order_ms_median for f in results], "o-", label="median")
    axes[0].plot(sizes, [f.order_ms_p99 for f in results], "s--", label="99th percentile")
    axes[0].axhline(200, color="grey", lw=1, ls=":")
    axes[0].set_ylabel("order from root to last agent, ms")
    axes[0].legend()
    axes[1].plot(sizes, [f.cpu_hosts for f in results], "o-", label="hosts")
    axes[1].plot(sizes, [f.cpu_world for f in results], "s--", label="world")
    axes[1].set_ylabel("CPU, cores")
    axes[1].legend()
    axes[2].plot(sizes, [f.memory_hosts for f in results], "o-", label="hosts")
    axes[2].plot(sizes, [f.memory_world for f in results], "s--", label="world")
    axes[2].set_ylabel("memory, MB")
    axes[2].legend()
    for axis in axes:
        axis.set_xscale("log")
        axis.set_yscale("log")
        for side in (axis.xaxis, axis.yaxis):
            side.set_major_formatter(StrMethodFormatter("{x:,g}"))
            side.set_minor_formatter(NullFormatter())
        axis.set_xlabel("agents")
        axis.grid(alpha=0.3)
    figure.savefig(path)


def main(
    sizes: Annotated[str, typer.Option(help="Numbers of agents.")] = SIZES,
    per_host: Annotated[int, typer.Option(help="Agents per host, of at least two.")] = 2500,
    seconds: Annotated[float, typer.Option(help="How long to measure each size, s.")] = 60.0,
    factor: Annotated[float, typer.Option(help="Speed, of real time at 10 Hz.")] = 1.0,
    preferred: Annotated[
        bool,
        typer.Option(help="Raise the priority of the swarm's processes; needs privileges."),
    ] = False,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    plot_to: Annotated[str, typer.Option("--plot", help="File for a plot, PNG or SVG.")] = "",
) -> None:
    """Measure how swarms grow."""
    here = str(Path(__file__).resolve().parent)
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (here, os.environ.get("PYTHONPATH"))))
    results = []
    for size in [int(text) for text in sizes.split(",")]:
        hosts = max(2, math.ceil(size / per_host))
        results.append(measure(size, hosts, seconds, factor, preferred=preferred))
        show(results)
        if json:
            # JSON has no infinity, which stands for an order that not all agents reported.
            figures = [
                {k: None if v == math.inf else v for k, v in asdict(result).items()}
                for result in results
            ]
            Path(json).write_text(json_module.dumps(figures, indent=2) + "\n", encoding="utf-8")
        if plot_to:
            plot(results, Path(plot_to))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    typer.run(main)
