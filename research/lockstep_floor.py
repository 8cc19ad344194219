"""Compares rounds of lockstep with the least that messages between the same processes cost.

A bare loop is two processes that send each other a small message in turns. A floor has the
processes of a swarm and its messages, and does nothing else: a world sends percepts and waits for
the actions. Keepaway is played by the same numbers of processes and agents. All are up at once,
and each is measured for a short time, turn by turn; ratios are of the same turn.

    scripts/python research/lockstep_floor.py --json floor.json
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from array import array
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer
from report import progress, tell

BARE = "bare_1"
KINDS = ("each", "shared", "raw", "rawshared", "host")
"""A topic per agent, one for all, the same two with bytes for messages, and all agents in one
process; followed by the number of agents."""
SIZE = 40  # numbers in a percept
SWARM = """
swarm: floor
domain: keepaway
start_from: {library}
behavior: Keepaway
{hosts}
world: {{kind: keepaway, pace: lockstep, paused: true, parameters: {{keepers: {keepers}}}}}
agents: {{keeper: {{count: {agents}}}}}
"""

Measure = Callable[[int], float]
"""Returns the time of a number of rounds, s."""


def child(kind: str, index: int, agents: int) -> None:
    """Be the world of a floor, if the index is 0, or one of its agents, or the host of all."""
    import rclpy
    from hitab_msgs import msg
    from rclpy.experimental import EventsExecutor
    from rclpy.serialization import serialize_message
    from std_msgs.msg import UInt64

    from hitab_ros import qos

    rclpy.init()
    node = rclpy.create_node(f"{kind}_{index}", start_parameter_services=False)
    executor = EventsExecutor()
    executor.add_node(node)
    raw, hosted = kind.startswith("raw"), kind == "host"
    shared = kind in ("shared", "rawshared", "host")
    if kind == "bare":
        to_agent, to_world = UInt64, UInt64
    elif shared:
        to_agent, to_world = msg.PerceptBatch, msg.ActionBatch if hosted else msg.Action
    else:
        to_agent, to_world = msg.Percept, msg.Action
    percept, action = to_agent(), to_world()
    if kind != "bare":
        percept.values = array("d", [0.5]) * (SIZE * agents if shared else SIZE)
        action.values = array("d", [0.5]) * (3 * agents if hosted else 3)
    sent = {"percept": percept, "action": action}
    if raw:
        sent = {name: serialize_message(message) for name, message in sent.items()}
    topics = [f"{kind}{agents}/percept_{0 if shared else i + 1}" for i in range(agents)]

    def subscribe(kind_of_message: Any, topic: str, take: Callable[[Any], None]) -> None:
        node.create_subscription(kind_of_message, topic, take, qos.CYCLE, raw=raw)

    if index:
        answers = node.create_publisher(to_world, f"{kind}{agents}/actions", qos.CYCLE)
        subscribe(to_agent, topics[index - 1], lambda _: answers.publish(sent["action"]))
        while True:
            executor.spin_once(1.0)

    answered = [0]

    def count(_: Any) -> None:
        answered[0] += 1

    publishers = [node.create_publisher(to_agent, topic, qos.CYCLE) for topic in sorted({*topics})]
    subscribe(to_world, f"{kind}{agents}/actions", count)
    awaited = 1 if hosted else agents
    while node.count_publishers(f"{kind}{agents}/actions") < awaited or any(
        one.get_subscription_count() < (awaited if shared else 1) for one in publishers
    ):
        executor.spin_once(0.05)
    print(flush=True)
    for line in sys.stdin:
        began = time.perf_counter()
        for _ in range(int(line)):
            answered[0] = 0
            for publisher in publishers:
                publisher.publish(sent["percept"])
            while answered[0] < awaited:
                executor.spin_once(1.0)
        print(time.perf_counter() - began, flush=True)


@contextlib.contextmanager
def floor(kind: str, agents: int) -> Iterator[Measure]:
    """Start the processes of a floor."""
    count = 1 if kind == "host" else agents
    processes = []
    for index in range(count, -1, -1):
        command = [sys.executable, __file__, "--child", f"{kind},{index},{agents}"]
        pipe = subprocess.PIPE if index == 0 else subprocess.DEVNULL
        out = subprocess.PIPE if index == 0 else None
        processes.append(subprocess.Popen(command, stdin=pipe, stdout=out, text=True))
    world = processes[-1]
    assert world.stdin
    assert world.stdout
    world.stdout.readline()

    asks, answers = world.stdin, world.stdout

    def measure(rounds: int) -> float:
        print(rounds, file=asks, flush=True)
        return float(answers.readline())

    try:
        yield measure
    finally:
        for process in processes:
            process.kill()
            process.wait()


@contextlib.contextmanager
def keepaway(agents: int, hosts: int) -> Iterator[Measure]:
    """Start a swarm that plays keepaway."""
    from hitab_bringup.processes.bringing_up import temporary_swarm
    from hitab_bringup.swarm_files.swarm_file import read_swarm
    from hitab_client.runs.shipped import shipped

    with TemporaryDirectory() as folder:
        file = Path(folder, "floor.yaml")
        library = shipped("libraries", "keepaway")
        count = f"hosts: {hosts}" if hosts else ""
        file.write_text(
            SWARM.format(agents=agents, keepers=max(agents, 2), hosts=count, library=library)
        )
        with temporary_swarm(read_swarm(file), progress=lambda *_: None) as swarm:

            def measure(rounds: int) -> float:
                began = time.perf_counter()
                swarm.world.step(rounds, seconds=60.0)
                return time.perf_counter() - began

            yield measure


def main(
    turns: Annotated[int, typer.Option(help="How often each is measured.")] = 15,
    rounds: Annotated[int, typer.Option(help="Rounds of each measurement.")] = 1000,
    agents: Annotated[str, typer.Option(help="Numbers of agents.")] = "1,3",
    kinds: Annotated[str, typer.Option(help="Floors to measure.")] = ",".join(KINDS),
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    child_of: Annotated[str, typer.Option("--child", hidden=True)] = "",
) -> None:
    """Compare keepaway in lockstep with its floors and with a bare loop."""
    if child_of:
        role, index, count = child_of.split(",")
        return child(role, int(index), int(count))
    numbers = [int(number) for number in agents.split(",")]
    os.environ.setdefault("ROS_DOMAIN_ID", "97")
    found: dict[str, list[float]] = {}
    with contextlib.ExitStack() as stack:
        measures = {BARE: stack.enter_context(floor("bare", 1))}
        for number in numbers:
            for kind in kinds.split(","):
                measures[f"{kind}_{number}"] = stack.enter_context(floor(kind, number))
            for name, hosts in (("keepaway", 0), ("keepaway_hosted", 1)):
                measures[f"{name}_{number}"] = stack.enter_context(keepaway(number, hosts))
        for turn in range(turns + 1):
            progress(f"turn {turn} of {turns}")
            for name, measure in measures.items():
                rate = rounds / measure(rounds)
                if turn:  # the first one warms up
                    found.setdefault(name, []).append(rate)
    progress("")
    tell(
        f"Rounds per second, medians of {turns} turns of {rounds} rounds",
        {name: round(median(rates)) for name, rates in found.items()},
    )
    ratios = {
        name: round(median(a / b for a, b in zip(rates, found[BARE], strict=True)), 3)
        for name, rates in found.items()
    }
    tell("Ratios to the bare loop", ratios, json)


if __name__ == "__main__":
    typer.run(main)
