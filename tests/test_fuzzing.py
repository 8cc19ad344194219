"""Whatever is sent, no process ends, nothing is written elsewhere, and the swarm obeys afterwards.

``--long`` sends for a minute.
"""

from __future__ import annotations

import array
import contextlib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import pytest
from fuzzing import Fuzzer
from hitab_msgs import msg
from rclpy.duration import Duration
from waiting import within

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client.connecting.ros_link import RosLink
from hitab_client.runs.run_processes import process_states
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core.operations import Perform
from hitab_ros import EmergencySwitch, names
from hitab_ros.nodes.fault_texts import STOPPED

SECONDS = 60.0
LOG_MAX = 300_000  # bytes of one process
MEMORY_MAX = 300_000_000  # bytes that one process may have grown by

CHAIN = """\
swarm: crammed_foragers
domain: foraging
world:
  kind: foraging
  pace: realtime
  seed: 1
  parameters: {foragers: 2}
agents: {forager: {count: 2}}
kinds:
  Squad: {orders: {Explore: Forward, Rest: Stop}}
commanders:
  squad: {kind: Squad, commands: forager, behavior: Explore}
"""
LARGE = 32_000_000  # bytes of a message
FORAGING = """\
swarm: fuzzed_foragers
domain: foraging
hosts: 2
world:
  kind: foraging
  pace: realtime
  seed: 1
  parameters: {foragers: 12}
agents: {forager: {count: 12}}
kinds:
  Squad: {orders: {Explore: Forward, Rest: Stop}}
  Chief: {orders: {Explore: Explore, Rest: Rest}}
commanders:
  squad: {kind: Squad, commands: {forager: 4}}
  chief: {kind: Chief, commands: squad, behavior: Explore}
"""


def files(folder: Path, leave_out: Path) -> set[tuple[str, int]]:
    """Return the files in a folder with their sizes, but for one folder in it."""
    return {
        (str(path), path.stat().st_size if path.is_file() else 0)
        for path in folder.rglob("*")
        if leave_out not in (path, *path.parents)
    }


def elsewhere() -> set[str]:
    """Return what has the name that the fuzzer's paths have, where they may lead."""
    places = (Path("/"), Path("/tmp"), Path.home(), Path.cwd())
    return {str(path) for place in places for path in place.glob("*fuzzed*")}


def pids(running: RunningSwarm) -> dict[str, int]:
    return {s["name"]: s["pid"] for s in process_states(running.record)}


def memory(running: RunningSwarm) -> dict[str, int]:
    return {name: psutil.Process(pid).memory_info().rss for name, pid in pids(running).items()}


def logs(running: RunningSwarm) -> dict[str, int]:
    return {path.name: path.stat().st_size for path in (running.folder.path / "logs").iterdir()}


def between_hosts(sent: Iterable[str]) -> set[str]:
    """Return the topics of the swarm and of each host on which hosts hear others."""
    hosts = {topic.split("/")[1] for topic in sent if topic.startswith("/host_of_")}
    assert len(hosts) > 1
    of_swarm = {names.HOSTS, names.STATUSES, names.COMMANDS, names.ALIVE}
    return {f"/{name}" for name in of_swarm} | {
        f"/{host}/{name}" for host in hosts for name in (names.ORDERS, names.REPORTS)
    }


@contextlib.contextmanager
def fuzzed(text: str, folder: Path, seed: int, seconds: float) -> Iterator[RunningSwarm]:
    """Bring a swarm up, send it whatever there is, and check that it is as it was."""
    description = parse_swarm(text, folder / "swarm.yaml")
    run = folder / "run"
    with temporary_swarm(description, run) as running:
        agents = sorted(running.agents.statuses)
        words = [*agents, *(path.name for path in run.iterdir())]
        for agent in (agents[0], agents[-1]):
            known = running.agents.vocabulary(agent)
            words += [word.name for word in (*known.behaviors, *known.features)]
            words += known.targets
        before, files_before, elsewhere_before = pids(running), files(folder, run), elsewhere()
        memory_before = memory(running)
        with RosLink(running.record.domain_id) as link:
            fuzzer = Fuzzer(link, seed, agents)
            fuzzer.learn(words)
            fuzzer.run(seconds)
            fuzzer.close()
        print(f"sent {sum(fuzzer.sent.values())} to {len(fuzzer.sent)}: {fuzzer.sent}")
        assert fuzzer.sent.keys() >= between_hosts(fuzzer.sent), (
            "not all that hosts hear was tried"
        )
        print(f"answered {fuzzer.answered}, not {fuzzer.unanswered}; logs {logs(running)}")
        assert pids(running) == before, "a process has ended"
        assert files(folder, run) == files_before, "something was written outside the run folder"
        assert elsewhere() == elsewhere_before
        assert max(logs(running).values()) < LOG_MAX
        grown = {name: size - memory_before[name] for name, size in memory(running).items()}
        print(f"grown by {grown}")
        assert max(grown.values()) < MEMORY_MAX
        # By somebody who comes later: who listened all the time may still see what was forged.
        with RosLink(running.record.domain_id) as link:
            said: list[str] = []
            link.node.guard.log = lambda text, *_: said.append(text)
            clients = SwarmClient(link, running.record.agents), WorldClient(link)
            clients[0].watch_all()
            later = replace(running, link=link, agents=clients[0], world=clients[1])
            clients[1].wait(SECONDS)
            let_go(later, agents)
            yield later
            assert not said, "the swarm itself has sent what it would refuse from others"
        assert pids(running) == before, "a process has ended"


def stopped(running: RunningSwarm) -> list[str]:
    """Return the fault of a world that an emergency stop holds."""
    return [fault for fault in running.world.wait().faults if fault.startswith(STOPPED)]


def let_go(running: RunningSwarm, agents: list[str]) -> None:
    """End what the fuzzer has begun as a demonstrator: trainings, a stopped and paused world."""
    switch = EmergencySwitch(running.link.node)

    def released() -> bool:
        switch.set(False, "the test")
        return not stopped(running)

    assert running.link.spin_until(released, SECONDS, 0.2)
    for agent in agents:
        running.agents.await_agent(agent, SECONDS)  # its backlog may be long
        running.agents.do(agent, Perform())
    running.world.control("pace", pace="lockstep")
    running.world.control("resume")


def fresh(running: RunningSwarm) -> None:
    """Wait until the world has said itself how it is; the fuzzer spoke in its name."""
    for _ in range(3):
        heard = running.world.status
        assert running.link.spin_until(
            lambda heard=heard: running.world.status is not heard, SECONDS
        )


def goes_on(running: RunningSwarm) -> bool:
    """Whether the world plays ten more cycles."""
    fresh(running)
    begun = running.world.status.cycle

    def played() -> bool:
        if running.world.status.mode == "paused":
            # The fuzzer has asked for some episodes, after which a world pauses.
            running.world.control("resume")
        return running.world.status.cycle > begun + 10

    return running.link.spin_until(played, SECONDS)


def behaviors(running: RunningSwarm, kind: str) -> set[str]:
    found = running.agents.statuses.items()
    return {status.behavior for name, status in found if name.startswith(kind)}


def doing(running: RunningSwarm) -> str:
    """Return what each agent and commander does, and why, for the message of a failure."""
    return "\n".join(
        f"{name}: {s.mode} {s.behavior!r}, {s.order.behavior!r} waits {s.order.waits}, cycle "
        f"{s.cycle}, {s.last_error} {list(s.faults)}"
        for name, s in running.agents.statuses.items()
    )


@pytest.mark.long
def test_two_levels_of_commanders_are_obeyed_whatever_was_sent(
    home: Path, tmp_path: Path, request: pytest.FixtureRequest
):
    seconds = 60.0 if request.config.getoption("long") else 8.0
    with fuzzed(FORAGING, tmp_path, 1, seconds) as running:
        # What is in force already is not ordered again: first something else on each level.
        for order in ("Rest", "Explore"):
            running.agents.do("chief", Perform(order))
        assert running.link.spin_until(lambda: behaviors(running, "squad") == {order}, SECONDS), (
            doing(running)
        )
        for order, meant in (("Rest", "Stop"), ("Explore", "Forward"), ("Rest", "Stop")):
            running.agents.do("chief", Perform(order))
            assert running.link.spin_until(
                lambda meant=meant: behaviors(running, "forager") == {meant}, SECONDS
            ), doing(running)
            assert goes_on(running)
        assert not running.world.status.missing


def peaks(running: RunningSwarm) -> dict[str, int]:
    """Return the most memory that each process has had, bytes."""
    found = {}
    for name, pid in pids(running).items():
        status = Path(f"/proc/{pid}/status").read_text()
        found[name] = 1024 * int(status.split("VmHWM:")[1].split()[0])
    return found


def test_what_large_messages_take_is_given_back_and_the_swarm_goes_on(home: Path, tmp_path: Path):
    """The middleware would keep the room of each, and the world would read them for seconds."""
    with temporary_swarm(parse_swarm(CHAIN, tmp_path / "swarm.yaml"), tmp_path / "run") as running:
        assert goes_on(running)
        node, before = running.link.node, memory(running)
        text, values = "x" * LARGE, array.array("d", bytes(LARGE))
        sent: dict[str, list[Any]] = {
            "Action": 3 * [msg.Action(agent="forager_1", values=values)],
            "Command": 3 * [msg.Command(behavior=text)],
            "Reports": 2 * [msg.Reports(reports=200_000 * [msg.Report(agent="forager_1")])],
        }
        publishers = [
            (node.create_publisher(getattr(msg, kind), topic, 10), messages)
            for kind, messages in sent.items()
            for topic in running.link.topics_of_type(f"hitab_msgs/msg/{kind}")
        ]
        assert len(publishers) >= 5, "the world, two agents and a commander listen"
        for publisher, messages in publishers:
            assert within(SECONDS, publisher.get_subscription_count)
            for message in messages:
                publisher.publish(message)
        # They are acknowledged when they are in the room of the middleware.
        for publisher, _ in publishers:
            assert publisher.wait_for_all_acked(Duration(seconds=SECONDS))
        print("peaks", {name: size - before[name] for name, size in peaks(running).items()})

        def grown() -> dict[str, int]:
            return {name: size - before[name] for name, size in memory(running).items()}

        assert goes_on(running)
        assert within(SECONDS, lambda: max(grown().values()) < LARGE), grown()
        running.agents.do("squad", Perform("Rest"))
        assert running.link.spin_until(lambda: behaviors(running, "forager") == {"Stop"}, SECONDS)
