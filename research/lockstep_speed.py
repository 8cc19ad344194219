"""Compares the speed of a keepaway game in lockstep with the limit that DDS sets.

It compares a bare loop, in which one process publishes a message and waits until three others
have answered, with the keepaway world and three keeper processes that perform the trained Keepaway
automaton. Both run all the time and are measured in short alternating turns, so that changes of
the machine's speed affect both. The ratio is the median of the turns' ratios.

    scripts/python research/lockstep_speed.py --turns 15 --json lockstep.json
"""

from __future__ import annotations

import contextlib
import itertools
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Annotated

import typer
from report import tell

KEEPERS = 3
EPISODES = 5  # that are played at a time

Measure = Callable[[float], tuple[int, float, int]]
"""Runs for a number of seconds; returns cycles, their duration in s, and missed deadlines."""


def answer(name: str) -> None:
    """Run one of the answering processes."""
    from hitab_msgs.msg import Action, Percept

    from hitab_ros import qos
    from hitab_ros.spinning import Spinner, make_node, run

    def start(spinning: Spinner) -> None:
        node = make_node(name)
        publisher = node.create_publisher(Action, "bare_answer", qos.CYCLE)
        reply = Action(agent=name)

        def respond(message: Percept) -> None:
            reply.sequence = message.sequence
            publisher.publish(reply)

        node.create_subscription(Percept, "bare_state", respond, qos.CYCLE)
        spinning.executor.add_node(node)

    sys.exit(run(start, []))


@contextlib.contextmanager
def bare() -> Iterator[Measure]:
    """Yield a publish-and-wait-for-all loop with three processes."""
    from hitab_msgs.msg import Action, Percept

    from hitab_ros import qos
    from hitab_ros.spinning import make_node, spinner

    program = [sys.executable, __file__, "--answer"]
    with contextlib.ExitStack() as stack:
        for i in range(KEEPERS):
            process = stack.enter_context(subprocess.Popen([*program, f"bare_{i}"]))
            stack.callback(process.terminate)
        spinning = stack.enter_context(spinner([]))
        node = make_node("bare_world")
        spinning.executor.add_node(node)
        publisher = node.create_publisher(Percept, "bare_state", qos.CYCLE)
        waiting: set[str] = set()
        state = Percept()

        def take(reply: Action) -> None:
            if reply.sequence == state.sequence:
                waiting.discard(reply.agent)

        node.create_subscription(Action, "bare_answer", take, qos.CYCLE)
        if not spinning.spin_until(
            lambda: (
                publisher.get_subscription_count() == KEEPERS
                and node.count_publishers("bare_answer") == KEEPERS
            ),
            20.0,
        ):
            raise SystemExit("error: the answering processes did not start")

        def measure(seconds: float) -> tuple[int, float, int]:
            cycles, began = 0, time.perf_counter()
            while (passed := time.perf_counter() - began) < seconds:
                state.sequence += 1
                waiting.update(f"bare_{i}" for i in range(KEEPERS))
                publisher.publish(state)
                while waiting:
                    spinning.executor.spin_once(timeout_sec=1.0)
                cycles += 1
            return cycles, passed, 0

        yield measure


@contextlib.contextmanager
def keepaway(library: Path) -> Iterator[Measure]:
    """Yield a swarm that plays keepaway in lockstep."""
    from hitab_bringup.bringing_up import temporary_swarm
    from keepaway_world.verbs.evaluation import play_lockstep, trained_keepers

    swarm = trained_keepers(library, "Keepaway", {})
    with temporary_swarm(swarm, progress=lambda *_: None) as running:
        seeds = itertools.count(step=EPISODES)

        def measure(seconds: float) -> tuple[int, float, int]:
            cycles, passed, missed = 0, 0.0, 0
            while passed < seconds:
                played, took, late = play_lockstep(running, EPISODES, next(seeds), lambda *_: None)
                cycles += sum(p.cycles for p in played)
                passed += took
                missed += late
            return cycles, passed, missed

        measure(0.1)
        yield measure


def main(
    seconds: Annotated[float, typer.Option(help="Length of each turn.")] = 1.5,
    turns: Annotated[int, typer.Option(help="Number of turns of each of the two.")] = 15,
    library: Annotated[Path | None, typer.Option(help="Folder of a trained library.")] = None,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    role: Annotated[str, typer.Option("--answer", hidden=True)] = "",
) -> None:
    """Compare keepaway in lockstep with a bare publish-and-wait-for-all loop."""
    if role:
        answer(role)
    from hitab_client.domain_ids import reserved
    from hitab_client.shipped import shipped

    trained = library or shipped("libraries", "keepaway")
    loops, games, missed = [], [], 0
    with keepaway(trained) as game, reserved() as domain:
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        with bare() as loop:
            for _ in range(turns):
                for measure, rates in ((loop, loops), (game, games)):
                    cycles, passed, late = measure(seconds)
                    rates.append(cycles / passed)
                    missed += late
    tell(
        f"Lockstep with {KEEPERS} keeper processes, medians of {turns} turns",
        {
            "bare_cycles_per_s": round(median(loops)),
            "keepaway_cycles_per_s": round(median(games)),
            "ratio": median(game / loop for game, loop in zip(games, loops, strict=True)),
            "missed_deadlines": missed,
        },
        json,
    )


if __name__ == "__main__":
    typer.run(main)
