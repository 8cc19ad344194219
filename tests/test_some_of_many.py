"""Some agents of a large swarm are used as if alone: by programs of ROS, and by demonstrators."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from hitab_msgs import msg, srv
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import qos_profile_sensor_data

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client.runs.shipped import shipped
from hitab_client.swarm_client import SwarmClient
from hitab_core.operations import BeginTraining, Command, Distribute, SaveBehavior, Test
from hitab_ros import names, qos

SECONDS = 60.0
HOSTS = 2
SQUAD = 5


def description(agents: int) -> str:
    return f"""
swarm: many
domain: foraging
start_from: {shipped("libraries", "foraging")}
behavior: Stop
hosts: {HOSTS}
world:
  kind: foraging
  factor: 0.5
  parameters: {{foragers: {agents}, width: 400.0, height: 400.0}}
  paused: true
agents:
  forager: {{count: {agents}}}
kinds:
  Leader: {{orders: {{RotateLeft: RotateLeft, Stop: Stop}}}}
commanders:
  squad: {{kind: Leader, commands: {{forager: {SQUAD}}}}}
"""


@pytest.fixture(scope="module", params=[300, pytest.param(5000, marks=pytest.mark.long)])
def swarm(
    home: Path, tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> Iterator[RunningSwarm]:
    """Return a paused swarm of many agents in two hosts."""
    folder = tmp_path_factory.mktemp("many")
    text = description(request.param)
    with temporary_swarm(parse_swarm(text, folder / "many.yaml"), folder / "run") as running:
        yield running


@pytest.fixture
def lot(swarm: RunningSwarm) -> list[str]:
    """Return agents that are chosen by lot, each of another squad."""
    squads = len(swarm.record.commanders)
    chosen = random.Random(47).sample(range(squads), 3 if squads < 1000 else 10)
    return [f"forager_{SQUAD * squad + 1}" for squad in chosen]


class Program:
    """A program of ROS 2 that knows nothing of HiTAB but its messages, as the `ros2` command."""

    def __init__(self, domain: int) -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = rclpy.create_node("program", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def until(self, done: Callable[[], Any]) -> None:
        """Spin until something is so."""
        end = time.monotonic() + SECONDS
        while not done():
            assert time.monotonic() < end
            self._executor.spin_once(timeout_sec=0.02)

    def publish_once(self, kind: Any, topic: str, message: Any) -> None:
        """Publish to the first subscription that matches, like `ros2 topic pub --once`."""
        publisher = self.node.create_publisher(kind, topic, 10)
        self.until(publisher.get_subscription_count)
        publisher.publish(message)

    def echo_once(self, kind: Any, topic: str) -> Any:
        """Return a message of a topic, like `ros2 topic echo --once`."""
        came: list[Any] = []
        # The command takes what a publisher offers; without one, it asks for no earlier message.
        offered = self.node.get_publishers_info_by_topic(topic)
        is_latched = offered and offered[0].qos_profile.durability == qos.LATCHED.durability
        profile = qos.LATCHED if is_latched else qos_profile_sensor_data
        self.node.create_subscription(kind, topic, came.append, profile)
        self.until(lambda: came)
        return came[0]

    def call(self, kind: Any, service: str, request: Any) -> Any:
        """Return the answer of a service, like `ros2 service call`."""
        client = self.node.create_client(kind, service)
        self.until(client.service_is_ready)
        answer = client.call_async(request)
        self.until(answer.done)
        return answer.result()

    def leave(self) -> None:
        """Leave the ROS graph."""
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()


def test_programs_of_ros_use_an_agent_and_leave_nothing_behind(
    swarm: RunningSwarm, lot: list[str]
) -> None:
    one, squad = lot[0], "squad_7"
    node, statuses = swarm.link.node, swarm.agents.statuses

    def ends() -> set[str]:
        """Return the topics and services of the agent and of the commander."""
        known = [*node.get_topic_names_and_types(), *node.get_service_names_and_types()]
        return {name for name, _ in known if name.startswith((f"/{one}/", f"/{squad}/"))}

    before = ends()
    for name in ("first", "second"):
        program = Program(swarm.record.domain_id)
        request = srv.BeginTraining.Request(automaton=name, features=["HoldsABox"], discard=True)
        assert program.call(srv.BeginTraining, f"/{one}/begin_training", request).success
        program.publish_once(msg.Command, f"/{one}/command", msg.Command(behavior="Forward"))
        assert swarm.link.spin_until(lambda: statuses[one].training.examples == 2, SECONDS)
        status = program.echo_once(msg.AgentStatus, f"/{one}/{names.STATUS}")
        assert (status.agent, status.behavior) == (one, name)
        assert len(program.echo_once(msg.CommanderStatus, f"/{squad}/group").subordinates) == SQUAD
        assert program.echo_once(msg.Order, f"/{squad}/{names.ORDER}").commander == squad
        swarm.world.control("resume")
        assert program.echo_once(msg.Percept, f"/{one}/{names.PERCEIVED}").values
        swarm.world.control("pause")
        stop = srv.Perform.Request(behavior="Stop")
        assert program.call(srv.Perform, f"/{one}/perform", stop).status.behavior == "Stop"
        program.leave()
    assert swarm.link.spin_until(lambda: ends() == before, SECONDS)


def test_agents_chosen_by_lot_are_taught_as_alone_by_two_demonstrators(
    swarm: RunningSwarm, lot: list[str]
) -> None:
    agents, link, statuses = swarm.agents, swarm.link, swarm.agents.statuses
    about = {"identity": swarm.record.identity, "processes": agents.processes}
    demonstrators = [
        SwarmClient(link, swarm.record.agents, demonstrator=name, **about)
        for name in ("ann", "bob")
    ]
    taught = {agent: demonstrators[number % 2] for number, agent in enumerate(lot)}
    for agent, client in taught.items():
        client.do(agent, BeginTraining("Stroll", features=["HoldsABox"], discard=True))
    many = link.node.create_publisher(msg.Commands, f"/{names.COMMANDS}", qos.EVENTS)
    assert link.spin_until(lambda: many.get_subscription_count() == HOSTS, SECONDS)
    commands = [msg.Command(behavior="Forward")] * len(lot)
    many.publish(msg.Commands(agents=lot, commands=commands))
    assert link.spin_until(
        lambda: all(statuses[one].training.examples == 2 for one in lot), SECONDS
    )
    receivers: set[str] = set()
    for agent, client in taught.items():
        training = client.do(agent, Command("RotateLeft")).status.training
        assert (training.examples, training.demonstrator) == (4, client.demonstrator)
        assert client.do(agent, Test(restart=True)).status.mode == "testing"
        client.do(agent, SaveBehavior())
        first = int(agent.rpartition("_")[2])
        mates = [f"forager_{first + number}" for number in range(1, SQUAD)]
        sent = client.distribute(agent, Distribute("Stroll", receivers=mates, start=True))
        assert (sent.accepted, sent.missing) == (mates, {})
        receivers.update(mates)

    def strolling() -> set[str]:
        found = {name for name, status in statuses.items() if status.behavior == "Stroll"}
        return found - {*lot}

    assert link.spin_until(lambda: strolling() == receivers, SECONDS)
    others = [name for name in statuses if name.startswith("forager_") and name != lot[0]]
    sent = agents.distribute(lot[0], Distribute("Stroll"))
    assert ({*sent.accepted}, sent.missing) == ({*others}, {})
    assert [ok for _, _, ok in agents.reload(agents.agents())] == [True] * HOSTS
