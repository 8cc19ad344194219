"""Swarms side by side in one ROS domain, and robots whose topics have other names."""

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from hitab_bringup.libraries.run_libraries import prepare
from hitab_bringup.processes.swarm_processes import processes
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client import RosLink, RunFolder
from hitab_client.connecting.identity import new_identity
from hitab_ros import qos

SECONDS = 60.0
SHARED = (
    *("/clock", "/diagnostics", "/emergency_stop", "/emergency_stop/state"),
    *("/parameter_events", "/rosout"),
)
"""Topics that ROS wants under these names; the first has this test's subscription only."""

WORLD = """\
swarm: {swarm}
world: {{kind: keepaway, pace: lockstep, paused: true}}
domain: keepaway
agents: {{keeper_1: {{}}, keeper_2: {{}}, keeper_3: {{}}}}
{more}
"""
CAPTAIN = """\
kinds: {Captain: {orders: {Rest: nothing}}}
commanders: {captain: {kind: Captain, commands: [keeper_1, keeper_2, keeper_3]}}
"""
ROBOTS = """\
swarm: robots
namespace: lab
domain: own_robot:DOMAIN
hosts: 1
agents:
  robot:
    count: 2
    remap: {report: "/desk/{agent}"}
    parameters: {speed: 0.5, name: "{agent}"}
    use_sim_time: true
  last: {host: last, remap: {report: told}}
processes:
  relay_1: {module: own_relay, namespace: robot_1, parameters: {speed: 2.0}}
  relay_2: {module: own_relay, namespace: robot_2, parameters: {speed: 2.0}}
"""
OWN_ROBOT = """
import json
from dataclasses import replace

from std_msgs.msg import String

from hitab_core import load_domain
from hitab_ros import qos


class Link:
    def __init__(self, node, world, on_percept):
        told = {
            "speed": node.declare_parameter("speed", 1.0).value,
            "name": node.declare_parameter("name", "").value,
            "node": node.get_fully_qualified_name(),
            "simulated": node.get_clock().ros_time_is_active,
        }
        self._publisher = node.create_publisher(String, "report", qos.LATCHED)
        self._publisher.publish(String(data=json.dumps(told)))

    def close(self):
        pass


DOMAIN = replace(load_domain("keepaway"), name="own", link="own_robot:Link")
"""
OWN_RELAY = """
import json
import os
import sys

from std_msgs.msg import String

from hitab_ros import make_node, qos, run


def start(spinning):
    node = make_node("relay")
    spinning.executor.add_node(node)
    told = {"speed": node.declare_parameter("speed", 1.0).value, "pid": os.getpid()}
    node.publisher = node.create_publisher(String, "alive", qos.LATCHED)
    node.publisher.publish(String(data=json.dumps(told)))


sys.exit(run(start))
"""


@pytest.fixture
def link(apart: Path) -> Iterator[RosLink]:
    """Yield a link in the domain of the test's swarms."""
    with RosLink(int(os.environ["ROS_DOMAIN_ID"])) as there:
        yield there


def bring_up(hitab, folder: Path, name: str, text: str, *options: str) -> None:
    path = folder / f"{name}.yaml"
    path.write_text(text)
    up = hitab("up", str(path), *options, timeout=110.0)
    assert up.returncode == 0, up.stderr


def test_two_swarms_with_the_same_names_live_side_by_side(hitab, link, tmp_path):
    # One in a process for each agent, one with all agents in one process.
    left = WORLD.format(swarm="left", more="namespace: left\nuse_sim_time: true")
    bring_up(hitab, tmp_path, "left", left)
    right = WORLD.format(swarm="keepers", more="hosts: 1")
    bring_up(hitab, tmp_path, "right", right, "--namespace", "right", "--use-sim-time")
    clocks: dict[str, int] = {}

    def listen(topic: str) -> None:
        def take(clock: Clock) -> None:
            clocks[topic] = round(10 * (clock.clock.sec + clock.clock.nanosec * 1e-9))

        link.subscribe(Clock, topic, take, qos.STREAM)

    for topic in ("/clock", "/left/clock", "/right/clock"):
        listen(topic)
    for swarm, steps in (("left", "5"), ("keepers_right", "12")):
        stepped = hitab("world", "step", steps, "--swarm", swarm)
        assert stepped.returncode == 0, stepped.stderr
    shown = {"/left/clock": 5, "/right/clock": 12}  # a cycle is 0.1 s
    assert link.spin_until(lambda: clocks == shown, SECONDS), clocks

    begun = hitab(
        "train", "keeper_1", "Chase", "-f", "DirectionTo(ball)", "--swarm", "keepers_right"
    )
    assert begun.returncode == 0, begun.stderr
    trained = {}
    for swarm in ("left", "keepers_right"):
        told = json.loads(hitab("status", "--swarm", swarm, "--json", "-").stdout)
        trained[swarm] = [a["agent"] for a in told["agents"] if a["mode"] == "training"]
    assert trained == {"left": [], "keepers_right": ["keeper_1"]}
    # The three agents of each take their time from their own clock, and so did this one.
    assert [link.node.count_subscribers(f"/{swarm}/clock") for swarm in ("left", "right")] == [
        4,
        4,
    ]
    outside = [
        topic
        for topic, _ in link.node.get_topic_names_and_types()
        if not topic.startswith(("/left/", "/right/")) and topic not in SHARED
    ]
    assert outside == []


@contextmanager
def launched(folder: Path, text: str, namespace: str) -> Iterator[str]:
    """Start the processes of a swarm as `ros2 launch` does; yield the swarm's identity."""
    swarm = parse_swarm(text, folder / "swarm.yaml").in_namespace(namespace)
    run = RunFolder(folder / namespace)
    run.prepare()
    prepare(swarm, run.path)
    identity = new_identity(swarm.name, launched=True)
    with ExitStack() as stack:
        for process in processes(swarm, run.path, identity):
            with (run.path / f"{process.name}.log").open("w") as log:
                there = subprocess.Popen(process.command, stdout=log, stderr=log)
            stack.callback(there.wait, SECONDS)
            stack.callback(there.terminate)
        yield identity


def test_a_swarm_launched_in_a_namespace_is_found_and_can_be_chosen_by_it(hitab, link, tmp_path):
    text = WORLD.format(swarm="trio", more="hosts: 1\n" + CAPTAIN)

    def agents(*options: str) -> list[str]:
        def answered() -> bool:
            told.append(hitab("status", "--json", "-", *options))
            return told[-1].returncode == 0 and len(json.loads(told[-1].stdout)["agents"]) == 4

        told: list[Any] = []
        assert link.spin_until(answered, SECONDS), told[-1].stderr
        return [agent["agent"] for agent in json.loads(told[-1].stdout)["agents"]]

    with launched(tmp_path, text, "red"):
        assert agents() == ["captain", "keeper_1", "keeper_2", "keeper_3"]
        assert "captain" in hitab("tree").stdout
        stepped = hitab("world", "step", "5")
        assert stepped.stdout == "stepped 5 cycles\n", stepped.stderr
        with launched(tmp_path, text, "blue") as blue:
            assert agents("--swarm", "/blue") == agents("--swarm", blue)
            assert hitab("world", "step", "7", "--swarm", "/blue").stdout == "stepped 7 cycles\n"
            for swarm, cycle in (("/red", 5), ("/blue", 7)):
                assert f"cycle {cycle}," in hitab("status", "--swarm", swarm).stdout
            refused = hitab("status")
            assert "choose one with --swarm NAME: /blue, /red" in " ".join(refused.stderr.split())
            refused = hitab("status", "--swarm", "/green")
            assert "no swarm answers in namespace /green of ROS" in " ".join(
                refused.stderr.split()
            )


def test_a_robots_topics_parameters_and_relay_are_as_its_swarm_file_says(
    hitab, link, tmp_path, monkeypatch
):
    (tmp_path / "own_robot.py").write_text(OWN_ROBOT)
    (tmp_path / "own_relay.py").write_text(OWN_RELAY)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    bring_up(hitab, tmp_path, "robots", ROBOTS)
    told: dict[str, dict] = {}

    def listen(topic: str) -> None:
        link.subscribe(
            String, topic, lambda text: told.update({topic: json.loads(text.data)}), qos.LATCHED
        )

    relays = ["/lab/robot_1/alive", "/lab/robot_2/alive"]
    for topic in ("/desk/robot_1", "/desk/robot_2", "/lab/last/told", *relays):
        listen(topic)
    assert link.spin_until(lambda: len(told) == 5, SECONDS), told
    first = {"speed": 0.5, "name": "robot_1", "node": "/lab/robot_1/agent", "simulated": True}
    assert told["/desk/robot_1"] == first
    assert told["/desk/robot_2"]["name"] == "robot_2"
    assert told["/lab/last/told"] == {
        "speed": 1.0, "name": "", "node": "/lab/last/agent", "simulated": False,
    }  # fmt: skip
    assert [told[relay]["speed"] for relay in relays] == [2.0, 2.0]

    # A relay that dies is started again, as agents are; and it has a log.
    ended = told[relays[1]]["pid"]
    os.kill(ended, signal.SIGKILL)
    assert link.spin_until(lambda: told[relays[1]]["pid"] != ended, SECONDS)
    logs = hitab("logs", "relay_2")
    assert logs.returncode == 0, logs.stderr
