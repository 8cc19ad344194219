"""Measures the studio in a real browser, with a swarm that is up or with a stand-in for one.

The stand-in moves its agents ten times a second; each second, one in ten reports a new state.

    scripts/python research/studio_scale.py --swarm thousand
    scripts/python research/studio_scale.py --agents 10000
"""

from __future__ import annotations

import multiprocessing
import sys
import tempfile
import time
from pathlib import Path

import psutil  # type: ignore[import-untyped]
import typer
from hitab_msgs.msg import (
    AgentStatus,
    CommanderStatus,
    Entity,
    HostStatuses,
    Subordinate,
    WorldState,
    WorldStatus,
)

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from browsing import browser, studio

from hitab_client import RosLink
from hitab_ros import names, qos

BATCH = 100
GROUP = 5
STATES = ("Search", "Carry", "Rest")

COUNTS_BYTES = """
    window.received = 0;
    const count = ({ data }) => (window.received += data.byteLength ?? data.length);
    window.WebSocket = class extends WebSocket {
        constructor(...given) {
            super(...given);
            this.addEventListener("message", count);
        }
    };
"""

COUNTED = "[studioField.drawn, studioField.frames, studioField.now.cycle, window.received]"


def stand_in(count: int) -> None:
    """Publish what a world and hosts with this many agents publish."""
    ants = [f"ant_{number}" for number in range(count)]
    with RosLink() as link:
        statuses = link.node.create_publisher(
            HostStatuses, names.of_swarm(names.STATUSES), qos.STATUSES
        )
        state = link.node.create_publisher(WorldState, names.of_world(names.STATE), qos.LATCHED)
        world = link.node.create_publisher(WorldStatus, names.of_world(names.STATUS), qos.LATCHED)
        world.publish(WorldStatus(world="plain", mode="running", pace="realtime", factor=1.0))

        def report(some: list[str], turn: int) -> None:
            batch = [
                AgentStatus(
                    agent=ant, process=1, sequence=turn, mode="performing", behavior="Forage",
                    active_path=[STATES[turn % 3]], perceived=True,
                )
                for ant in some
            ]  # fmt: skip
            groups = [
                CommanderStatus(
                    commander=some[i],
                    subordinates=[Subordinate(name=ant) for ant in some[i + 1 : i + GROUP]],
                )
                for i in range(0, len(some), GROUP)
            ]
            statuses.publish(HostStatuses(host="host", agents=batch, groups=groups))

        things = [
            Entity(name=ant, kind="ant", x=float(i % 100), y=float(i // 100), radius=0.2)
            for i, ant in enumerate(ants)
        ]
        turn, readers = 0, 0
        while True:
            began = time.monotonic()
            if readers < (readers := statuses.get_subscription_count()):
                for start in range(0, count, BATCH):
                    report(ants[start : start + BATCH], turn)
            elif turn % 10 == 0:
                for start in range(0, count // 10, BATCH):
                    report(ants[start : start + BATCH], turn)
            for thing in things:
                thing.x += 0.01
            turn += 1
            state.publish(WorldState(cycle=turn, width=100.0, height=100.0, entities=things))
            while (left := began + 0.1 - time.monotonic()) > 0.0:
                link.spin(left)


def measure(swarm: str = "", agents: int = 0, seconds: float = 10.0) -> None:
    """Open the page, wait for the field, and print what a second of it costs."""
    if agents:
        multiprocessing.get_context("spawn").Process(
            target=stand_in, args=(agents,), daemon=True
        ).start()
    with (
        tempfile.TemporaryDirectory() as folder,
        studio(Path(folder, "studio.log"), *filter(None, [swarm])) as address,
        browser() as opened,
    ):
        page = opened.new_page()
        page.add_init_script(COUNTS_BYTES)
        began = time.monotonic()
        page.goto(address)
        page.wait_for_function("window.studioField?.now", timeout=60_000)
        shown = time.monotonic() - began
        page.wait_for_timeout(5000)
        mine = psutil.Process().children(recursive=True)
        (served,) = (one for one in mine if "studio" in one.cmdline())

        def counts() -> list[float]:
            counted = page.evaluate(COUNTED)
            return [time.monotonic(), *counted, sum(served.cpu_times()[:2])]

        before = counts()
        page.wait_for_timeout(1000 * seconds)
        took, drawn, frames, cycles, size, busy = (
            b - a for a, b in zip(before, counts(), strict=True)
        )
        rows = len(page.query_selector_all(".agents .agent"))
        things = page.evaluate("studioField.roster.names.length")
        agents_found = page.inner_text(".agents .foot span")
        memory = served.memory_info().rss
        began = time.monotonic()
        served.terminate()
        served.wait(60)
        print(
            f"{things} things: {drawn / took:.1f} drawings/s, {frames / took:.1f} frames/s "
            f"of {cycles / took:.1f} cycles/s, "
            f"{size / took / 1e3:.0f} kB/s, {busy / took:.2f} cores, {memory / 1e6:.0f} MB; "
            f"shown after {shown:.1f} s, ended in {time.monotonic() - began:.1f} s; "
            f"{rows} rows, {agents_found}"
        )


if __name__ == "__main__":
    typer.run(measure)
