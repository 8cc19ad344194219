"""The cost of the studio with many agents: messages per second, frames, CPU of server and browser.

    scripts/python research/studio.py --agents 1000 --rate 10 --json studio.json

A node publishes the state of a world and the status of every agent, as many times a second as a
world of that size would; the studio shows it in as many headless browsers as asked for.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil
from report import tell

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

STATES = ("Search", "Attach", "ReturnHome", "Wander", "Wait", "Push", "Follow")
CHANGES = 0.5  # changes of state per agent and second


def publish(agents: int, rate: float) -> None:
    """Play the world and all agents until stopped."""
    from hitab_msgs.msg import AgentStatus, Entity, WorldState, WorldStatus

    from hitab_client.ros_link import RosLink
    from hitab_ros import qos

    draw = random.Random(1)
    side = 10.0 * math.sqrt(agents / 10)
    names = [f"agent_{i}" for i in range(agents)]
    with RosLink() as link:
        node = link.node
        state = node.create_publisher(WorldState, "/world/state", qos.LATCHED)
        status = node.create_publisher(WorldStatus, "/world/status", qos.LATCHED)
        own = [node.create_publisher(AgentStatus, f"/{n}/status", qos.LATCHED) for n in names]
        things = [
            Entity(
                name=name,
                kind="agent",
                x=draw.uniform(-side / 2, side / 2),
                y=draw.uniform(-side / 2, side / 2),
                heading=draw.uniform(-math.pi, math.pi),
                radius=0.25,
            )
            for name in names
        ]

        def change(i: int) -> None:
            path = [draw.choice(STATES)]
            message = AgentStatus(agent=names[i], mode="performing", behavior="Forage")
            message.active_path = path
            own[i].publish(message)

        for i in range(agents):
            change(i)
        status.publish(WorldStatus(world="benchmark", mode="running", pace="realtime", factor=1.0))
        cycle, due = 0, time.monotonic()
        while True:
            for thing in things:
                thing.heading += draw.uniform(-0.2, 0.2)
                thing.x = min(max(thing.x + 0.1 * math.cos(thing.heading), -side / 2), side / 2)
                thing.y = min(max(thing.y + 0.1 * math.sin(thing.heading), -side / 2), side / 2)
            cycle += 1
            state.publish(
                WorldState(
                    world="benchmark",
                    mode="running",
                    cycle=cycle,
                    episode_cycle=cycle,
                    width=side,
                    height=side,
                    entities=things,
                )
            )
            for _ in range(round(agents * CHANGES / rate)):
                change(draw.randrange(agents))
            due += 1 / rate
            link.spin_until(lambda until=due: time.monotonic() >= until, 1.0, 0.005)


def cpu_seconds(process: psutil.Process) -> float:
    """Return the CPU time of a process and its children."""
    total = 0.0
    for one in [process, *process.children(recursive=True)]:
        try:
            times = one.cpu_times()
            total += times.user + times.system
        except psutil.NoSuchProcess:
            continue
    return total


def measure(agents: int, rate: float, browsers: int, seconds: float) -> dict[str, float]:
    """Show so many agents and return the figures."""
    import browsing

    folder = Path(tempfile.mkdtemp(prefix="hitab-studio-"))
    os.environ["HITAB_HOME"] = str(folder)
    source = subprocess.Popen(
        [sys.executable, __file__, "--publish", "--agents", str(agents), "--rate", str(rate)]
    )
    try:
        with browsing.studio(folder / "log") as url, browsing.browser() as chrome:
            people = []
            for _ in range(browsers):
                page = chrome.new_page(viewport={"width": 1280, "height": 720})
                people.append(browsing.Person(page, url))
            for person in people:
                person.sees_field()
                person.waits_until(
                    lambda p=person: p.page.evaluate("window.studioField.now.n") == agents, "all"
                )
            people[0].page.wait_for_timeout(5000)  # until all statuses have arrived
            me = psutil.Process()
            studio = next(
                p for p in me.children() if "studio" in p.cmdline() and p.pid != source.pid
            )
            counters = "[window.studioField.frames, window.studioField.drawn]"
            before = [p.page.evaluate(counters) for p in people]
            cpu = cpu_seconds(studio), cpu_seconds(me) - cpu_seconds(studio)
            published = cpu_seconds(psutil.Process(source.pid))
            began = time.monotonic()
            people[0].page.wait_for_timeout(1000 * seconds)
            wall = time.monotonic() - began
            after = [p.page.evaluate(counters) for p in people]
            published = cpu_seconds(psutil.Process(source.pid)) - published
            used = cpu_seconds(studio) - cpu[0]
            others = cpu_seconds(me) - cpu_seconds(studio) - cpu[1] - published
            frames = [(b[0] - a[0]) / wall for a, b in zip(before, after, strict=True)]
            drawn = [(b[1] - a[1]) / wall for a, b in zip(before, after, strict=True)]
            complaints = sum(len(p.complaints) for p in people)
            return {
                "agents": agents,
                "browsers": browsers,
                "messages_per_s": rate + agents * CHANGES,
                "frames_per_s": min(frames),
                "drawn_per_s": min(drawn),
                "frame_bytes": 16 + 14 * agents,
                "server_cpu": used / wall,
                "browser_cpu": others / wall,
                "server_mb": studio.memory_info().rss / 1e6,
                "console_errors": complaints,
            }
    finally:
        source.terminate()
        source.wait(10)


def main() -> None:
    """Measure and report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--agents", type=int, default=1000)
    parser.add_argument("--rate", type=float, default=10.0, help="states of the world a second")
    parser.add_argument("--browsers", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--json", default=None)
    parser.add_argument("--publish", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.publish:
        publish(given.agents, given.rate)
        return
    from hitab_client.domain_ids import reserved

    with reserved() as domain:
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        figures = measure(given.agents, given.rate, given.browsers, given.seconds)
    tell("The studio with many agents (CPU: 1 is a whole core)", figures, given.json or "")


if __name__ == "__main__":
    main()
