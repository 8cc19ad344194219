"""Measures how many answers come late when a swarm's machines are joined by a network that loses.

Three network namespaces are the machines, and the switch of the tests joins them: it delays each
frame and loses some. Each machine runs a host with a third of the foragers, and the first also the
world, in real time. An answer is late if it has not come when its cycle ends. It must be run where
network namespaces can be made (as root, or with unprivileged user namespaces).

    scripts/python research/lossy_network_answers.py --sizes 15,300,1000 --rates 10,5
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

import psutil  # type: ignore[import-untyped]
import typer

MACHINES = 3
CYCLES_HZ = 10.0  # of foraging, in real time
SETTLE_S, START_S = 3.0, 60.0
FIELD_M = 8.5  # of the side of the field, times the square root of the number of foragers

SWARM = """\
swarm: lossy
domain: foraging
start_from: {libraries}/foraging
behavior: Forage
hosts: {machines}
world:
  kind: foraging
  pace: realtime
  factor: {factor}
  seed: 1
  parameters:
    {{foragers: {agents}, width: {side}, height: {side}, small_boxes: {boxes}, renew: true}}
agents:
  forager: {{count: {agents}}}
"""


@dataclass(frozen=True)
class Lateness:
    """How many answers were late.

    Attributes:
        late: share of the answers, 0 to 1.
        lost: share of the frames that the switch lost.
        frames: number of frames per cycle that left a machine.
    """

    agents: int
    rate: float
    cycles: int
    late: float
    lost: float
    frames: float


def observe(file: Path) -> None:
    """Write the cycle and the missed deadlines of the world to a file, as long as this runs."""
    from hitab_msgs.msg import WorldStatus

    from hitab_ros import make_node, names, qos
    from hitab_ros.nodes.spinning import run

    def start(spinning: Any) -> None:
        node = make_node("observer")

        def hear(status: WorldStatus) -> None:
            line = [status.cycle, status.missed_deadlines, len(status.missing)]
            partial = file.with_suffix(".partial")
            partial.write_text(json.dumps(line), encoding="utf-8")
            partial.replace(file)

        topic = names.of_world(names.STATUS)
        node.create_subscription(WorldStatus, topic, hear, qos.LATCHED)
        spinning.executor.add_node(node)

    sys.exit(run(start, []))


def hurry() -> None:
    """Give the switch and all processes of the machines priority over other work."""
    for process in psutil.Process().children(recursive=True):
        for thread in process.threads():
            os.sched_setscheduler(thread.id, os.SCHED_RR, os.sched_param(1))


def measure(
    agents: int,
    rate: float,
    seconds: float,
    delay_s: float,
    loss: float,
    domain: int,
    *,
    preferred: bool = False,
    variables: Mapping[str, str] = MappingProxyType({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}),
    multicast: bool = True,
) -> Lateness:
    """Play a swarm on three machines for a while."""
    from lossy_network import LossyNetwork

    from hitab_bringup.libraries.run_libraries import prepare
    from hitab_bringup.processes.swarm_processes import HOST_MODULE, processes
    from hitab_bringup.swarm_files.swarm_file import parse_swarm
    from hitab_client.connecting.dds_profile import choose_profile
    from hitab_client.runs.shipped import shipped

    with tempfile.TemporaryDirectory(prefix="hitab-lossy-") as place:
        folder = Path(place).resolve()
        text = SWARM.format(
            libraries=shipped("libraries", "foraging").parent,
            machines=MACHINES,
            factor=rate / CYCLES_HZ,
            agents=agents,
            side=max(50.0, FIELD_M * agents**0.5),
            boxes=max(5, agents // 5),
        )
        swarm = parse_swarm(text, folder / "lossy.yaml")
        prepare(swarm, folder)
        environment = {
            "ROS_DOMAIN_ID": str(domain),
            "FASTRTPS_DEFAULT_PROFILES_FILE": "",
            "FASTDDS_DEFAULT_PROFILES_FILE": "",
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            **variables,
        }
        choose_profile(environment)
        seen = folder / "seen.json"
        with LossyNetwork(MACHINES, delay_s, loss) as network:
            if not multicast:
                network.drop_multicast()
            if server := environment.get("ROS_DISCOVERY_SERVER"):
                address, port = server.split(":")
                line = ["fast-discovery-server", "-i", "0", "-l", address, "-p", port]
                network.run(1, line, folder / "server.log", ROS_DOMAIN_ID=str(domain))
            hosts = 0
            for process in processes(swarm, folder, "lossy-1"):
                machine = 1
                if process.module == HOST_MODULE:
                    hosts = machine = hosts + 1
                    named = {**process.parameters, "machine": f"machine_{machine}"}
                    process = replace(process, parameters=named)
                log = folder / f"{process.name}.log"
                network.run(machine, list(process.command), log, **environment)
            watch = [sys.executable, __file__, "--observe", str(seen)]
            network.run(1, watch, folder / "observer.log", **environment)

            def wait_for(condition: Any, timeout_s: float) -> list[int]:
                until = time.monotonic() + timeout_s
                while True:
                    found = json.loads(seen.read_text()) if seen.exists() else [0, 0, agents]
                    if condition(found):
                        return found
                    if time.monotonic() > until:
                        logs = "\n".join(f.read_text()[-500:] for f in folder.glob("*.log"))
                        raise SystemExit(f"the world is at {found}\n{logs}")
                    time.sleep(0.05)

            up = wait_for(lambda found: found[0] and not found[2], START_S)[0]
            if preferred:
                hurry()
            cycle, missed, _ = wait_for(lambda found: found[0] >= up + SETTLE_S * rate, START_S)
            before = network.heal()
            end, late, _ = wait_for(
                lambda found: found[0] >= cycle + seconds * rate, 3.0 * seconds + START_S
            )
            after = network.heal()
        played = end - cycle
        lost, passed = (after[key] - before[key] for key in ("lost", "passed"))
        return Lateness(
            agents,
            rate,
            played,
            (late - missed) / (played * agents),
            lost / (lost + passed),
            (lost + passed) / (MACHINES - 1) / played,
        )


def main(
    sizes: Annotated[str, typer.Option(help="Numbers of agents.")] = "15,300,1000",
    rates: Annotated[str, typer.Option(help="Cycles per second.")] = "10,5",
    seconds: Annotated[float, typer.Option(help="Duration of each measurement.")] = 20.0,
    delay: Annotated[float, typer.Option(help="One way, s.")] = 0.02,
    loss: Annotated[float, typer.Option(help="Share of lost frames.")] = 0.05,
    preferred: Annotated[
        bool, typer.Option(help="Take precedence over other work on this machine; as root.")
    ] = False,
    domain: Annotated[int, typer.Option(help="ROS domain inside of the network.")] = 35,
    observer: Annotated[str, typer.Option("--observe", hidden=True)] = "",
) -> None:
    """Measure the share of late answers over a network that loses."""
    if observer:
        observe(Path(observer))
    from lossy_network import why_not

    if why := why_not():
        raise SystemExit(why)
    typer.echo(f"one way {delay * 1e3:.0f} ms, {loss:.0%} of the frames lost")
    typer.echo(" agents     Hz  cycles   late answers  frames lost  frames a cycle")
    for agents in map(int, sizes.split(",")):
        for rate in map(float, rates.split(",")):
            one = measure(agents, rate, seconds, delay, loss, domain, preferred=preferred)
            typer.echo(
                f"{one.agents:>7} {one.rate:>6g} {one.cycles:>7} {one.late:>13.1%} "
                f"{one.lost:>12.1%} {one.frames:>15.0f}"
            )


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
    os.environ.setdefault("HITAB_HOME", tempfile.gettempdir())
    typer.run(main)
