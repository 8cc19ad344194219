"""Measures how long a swarm takes to start if each agent is its own process.

    scripts/python research/startup.py --sizes 10,25,50,100 --json startup.json

For each size: seconds until all agents and the world answer; CPU time of the processes by then, in
all and each, and the share of an idle Python process with rclpy; and what a process that joins
late receives from them, and when.
"""

from __future__ import annotations

import json as json_format
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Annotated, Any

import psutil
import typer
from report import tell

NOTHING = "import rclpy; rclpy.init(); rclpy.create_node('nothing'); rclpy.shutdown()"
LATE_S = 60.0


def floor(turns: int = 5) -> float:
    """Return the CPU seconds of a process with rclpy and one node that does nothing else."""
    taken = []
    for _ in range(turns):
        child = subprocess.Popen([sys.executable, "-c", NOTHING])
        usage = psutil.Process(child.pid)
        spent = 0.0
        while child.poll() is None:
            try:
                spent = sum(usage.cpu_times()[:2])
            except psutil.Error:
                break
            time.sleep(0.002)
        taken.append(spent)
    return sorted(taken)[turns // 2]


def description(agents: int) -> str:
    """Return the description of a swarm with this many agents, each its own process."""
    return (
        "swarm: startup\n"
        "domain: plain_world:DOMAIN\n"
        f"world: {{kind: plain, module: plain_world, paused: true, "
        f"parameters: {{agents: {agents}}}}}\n"
        f"agents: {{ant: {{count: {agents}}}}}\n"
    )


def measure(agents: int) -> dict[str, Any]:
    """Start a swarm and return the figures."""
    from hitab_bringup.bringing_up import temporary_swarm
    from hitab_bringup.swarm_file import parse_swarm
    from hitab_client.ros_link import RosLink
    from hitab_client.run_processes import process_states
    from hitab_client.swarm_client import SwarmClient

    began = time.monotonic()
    with temporary_swarm(parse_swarm(description(agents), Path("startup.yaml"))) as running:
        up = time.monotonic() - began
        pids = [state["pid"] for state in process_states(running.record)]
        cpu = sum(sum(psutil.Process(pid).cpu_times()[:2]) for pid in pids)
        began = time.monotonic()
        with RosLink(running.record.domain_id) as link:
            late = SwarmClient(link, running.record.agents)
            late.watch_all()
            link.spin_until(lambda: len(late.statuses) == agents, LATE_S)
            return {
                "processes": agents + 1,
                "up_s": up,
                "cpu_s": cpu,
                "cpu_s_each": cpu / (agents + 1),
                "late_hears": len(late.statuses),
                "late_s": time.monotonic() - began,
            }


def main(
    sizes: Annotated[str, typer.Option(help="Agents, separated by commas.")] = "10,25,50,100",
    json: Annotated[str, typer.Option(help="Write the figures here.")] = "",
) -> None:
    """Time the start of swarms of several sizes."""
    os.environ["PYTHONPATH"] = str(Path(__file__).parent)  # the processes of the swarm need it
    bare = floor()
    found = []
    for size in map(int, sizes.split(",")):
        figures = measure(size)
        found.append(figures)
        tell(f"{size} agents, each a process", figures)
    tell("A process that does nothing", {"cpu_s": bare})
    if json:
        text = json_format.dumps({"floor_cpu_s": bare, "sizes": found}, indent=2)
        Path(json).write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
