"""Measures what a host costs: creating the nodes of its agents, and a cycle of them.

A host's agents and commanders are created in this process; then its agents get percepts as from a
world, without a world's process. Each size runs in a process of its own.

    scripts/python research/host_costs.py --sizes 250,1000,2500
"""

from __future__ import annotations

import gc
import json
import os
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import psutil  # type: ignore[import-untyped]
import typer

CYCLES = 40
CYCLE_S = 0.1


@dataclass(frozen=True)
class Costs:
    """What a host costs, each per agent and commander, or per agent and cycle.

    Attributes:
        create_ms: CPU of creating the nodes, ms.
        join_ms: CPU of joining the swarm, ms.
        memory_mb: memory of a node that has joined, MB.
        cycle_us: CPU of the callback that answers percepts, µs.
        world_us: CPU of the world for sending a percept and taking the action of one agent, µs.
        process_us: CPU of the host's process in real time, with its commanders and DDS, µs.
    """

    agents: int
    nodes: int
    create_ms: float
    join_ms: float
    memory_mb: float
    cycle_us: float
    world_us: float
    process_us: float


def _memory_mb() -> float:
    return float(psutil.Process().memory_full_info().uss) / 1e6


def roster(agents: int, folder: Path) -> Path:
    """Write the roster of one host with all agents of a benchmark's swarm."""
    from hitab_bringup.libraries.run_libraries import prepare
    from hitab_bringup.swarm_files.swarm_file import parse_swarm
    from swarms import description

    swarm = parse_swarm(description(agents, 2), folder / "costs.yaml")
    prepare(swarm, folder)
    entries = [
        entry
        for file in sorted((folder / "rosters").iterdir())
        for entry in json.loads(file.read_text(encoding="utf-8"))
    ]
    file = folder / "all.json"
    file.write_text(json.dumps(entries), encoding="utf-8")
    return file


def measure(agents: int) -> Costs:
    """Create a host with so many agents, give them percepts, take it down."""
    with tempfile.TemporaryDirectory(prefix="hitab-costs-") as place:
        folder = Path(place).resolve()
        os.environ["ROS_DOMAIN_ID"] = str(os.getpid() % 90 + 10)
        from hitab_ros.nodes.spinning import spinner

        file = roster(agents, folder)
        with spinner(["--ros-args", "-r", "__ns:=/swarm", "-p", f"roster:={file}"]) as spinning:
            return _measure(spinning, agents)


def _measure(spinning: Any, agents: int) -> Costs:
    from hitab_agent.host.roster import read_roster
    from hitab_agent.host_main import GC_THRESHOLDS
    from hitab_agent.host_resources import HostResources
    from hitab_ros import make_node

    host = make_node("host")
    entries = read_roster(host)
    desk = make_node("host", namespace="/swarm/host_of_all", use_global_arguments=False)
    spinning.executor.add_node(desk)
    shared = HostResources(desk, is_host=True, on_demand=True, swarm="costs")
    gc.disable()
    before, began = _memory_mb(), time.process_time()
    nodes = []
    for entry in entries:
        node = entry.create("/swarm", "costs", shared)
        spinning.executor.add_node(node)
        nodes.append(node)
    created = time.process_time()
    for node in nodes:
        node.join()
    joined, memory = time.process_time(), _memory_mb() - before
    gc.collect()
    gc.freeze()
    gc.set_threshold(*GC_THRESHOLDS)
    gc.enable()
    (link,) = shared.links.values()
    assert shared.roster is not None
    shared.roster.publish()
    cycle, world, process = _cycles(spinning, link, shared, desk, agents)
    count = len(nodes)
    host.destroy_node()
    return Costs(
        agents,
        count,
        (created - began) / count * 1e3,
        (joined - created) / count * 1e3,
        memory / count,
        cycle / agents * 1e6,
        world / agents * 1e6,
        process / agents * 1e6,
    )


def _cycles(
    spinning: Any, link: Any, shared: Any, desk: Any, agents: int
) -> tuple[float, float, float]:
    """Return the CPU time of a cycle, s: of the callback, of the world, of the process."""
    from hitab_msgs import msg
    from plain_world import PlainWorld

    from hitab_ros import make_node
    from hitab_ros.messages.stamps import time_of
    from hitab_world.node.host_registry import HostRegistry
    from hitab_world.simulating.lockstep import RoundAnswers

    world = PlainWorld(agents)
    node = make_node("world", namespace="/swarm/world", use_global_arguments=False)
    answers = RoundAnswers(world.agents, lambda name: True)
    registry = HostRegistry(node, world.agents, answers.take)
    names = [one.agent_name for one in shared.nodes]
    registry._on_roster(
        msg.HostRoster(host="host_of_all", number=shared.roster.number, agents=names)
    )
    link.listen()
    spinning.spin_until(lambda: registry.look() and registry.present == 1, 10.0)
    percepts = Tap(registry._hosts["host_of_all"].publisher)
    actions = Tap(link._actions)
    registry._hosts["host_of_all"].publisher, link._actions = percepts, actions
    answers.look()

    def play(cycle: int) -> tuple[float, float]:
        common = {"stamp": time_of(cycle * CYCLE_S), "sequence": cycle, "cycle": cycle}
        began = time.process_time()
        answers.begin(cycle)
        registry.send(common, world.percept)
        world_s = time.process_time() - began
        batch = as_received(percepts.last)
        began = time.process_time()
        link._on_percepts(batch)
        host_s = time.process_time() - began
        answer = as_received(actions.last)
        began = time.process_time()
        registry._on_actions(answer)
        world_s += time.process_time() - began
        assert answers.complete
        world.step(answers.answers)
        return host_s, world_s

    direct = []
    for cycle in range(1, CYCLES + 1):
        direct.append(play(cycle))
        spinning.spin_until(lambda: False, CYCLE_S / 4)
    # Now as in a swarm: by DDS, in real time, with the work of timers in between.
    spent = 0.0
    for cycle in range(CYCLES + 1, 2 * CYCLES + 1):
        due = time.monotonic() + CYCLE_S
        answers.begin(cycle)
        common = {"stamp": time_of(cycle * CYCLE_S), "sequence": cycle, "cycle": cycle}
        registry.send(common, world.percept)
        began = time.process_time()
        while (left := due - time.monotonic()) > 0:
            spinning.spin_once(left)
        spent += time.process_time() - began
        registry._on_actions(as_received(actions.last))
        assert answers.complete
        world.step(answers.answers)
    node.destroy_node()
    return (*map(median, zip(*direct[5:], strict=True)), spent / CYCLES)


class Tap:
    """A publisher that also keeps the last message."""

    def __init__(self, publisher: Any) -> None:
        self._publisher = publisher
        self.last: Any = None

    def get_subscription_count(self) -> int:
        """Return how many subscriptions there are; the benchmark has the world's side."""
        return 1

    def publish(self, message: Any) -> None:
        """Publish a message."""
        self.last = message
        self._publisher.publish(message)


def as_received(message: Any) -> Any:
    """Return a message as its receiver gets it."""
    from rclpy.serialization import deserialize_message, serialize_message

    return deserialize_message(serialize_message(message), type(message))


def main(
    sizes: Annotated[str, typer.Option(help="Numbers of agents.")] = "250,1000,2500",
) -> None:
    """Measure what hosts cost."""
    typer.echo(" agents  nodes   create     join    memory     cycle    world  process")
    for size in map(int, sizes.split(",")):
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            costs = pool.submit(measure, size).result()
        typer.echo(
            f"{costs.agents:>7} {costs.nodes:>6} "
            f"{costs.create_ms:>5.2f} ms {costs.join_ms:>5.2f} ms {costs.memory_mb:>5.3f} MB "
            f"{costs.cycle_us:>6.1f} µs {costs.world_us:>5.1f} µs {costs.process_us:>5.1f} µs"
        )


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    typer.run(main)
