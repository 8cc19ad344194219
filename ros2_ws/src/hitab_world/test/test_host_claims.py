"""A world decides which host holds each agent, and refuses by name who claims those of another."""

from __future__ import annotations

import contextlib
from array import array
from collections.abc import Iterator
from typing import Any

import pytest
from hitab_msgs import msg
from rclpy.context import Context
from rclpy.experimental import EventsExecutor

from hitab_ros import names, qos
from hitab_ros.messages.pieces import PieceReader
from hitab_ros.messages.stamps import time_of
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.testing import context_of_its_own, spin_until
from hitab_world.node.host_registry import SwarmSettings
from hitab_world.node.percept_sender import PerceptSender

KEEPERS = ("keeper_1", "keeper_2", "keeper_3")
POND = SwarmSettings("pond-1")
MACHINES = SwarmSettings("pond-1", ("lab_1", "lab_2", "lab_3"))


class Swarm:
    """The sender of a world, and processes that answer it or claim to.

    Attributes:
        heard: the process that got the last percept of each agent, by agent.
        answered: the agents whose answers the world took.
        refused: refusals that the world reported.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._executor = EventsExecutor(context=context)
        self._stack = contextlib.ExitStack()
        self._stack.callback(self._executor.shutdown)
        self._sequence = 0
        self.heard: dict[str, str] = {}
        self.answered: set[str] = set()
        self.refused: list[str] = []
        self._answers: list[Any] = []

    def __enter__(self) -> Swarm:
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.close()

    def node(self, name: str) -> GuardedNode:
        node = GuardedNode("node", namespace=f"/{name}", context=self._context)
        self._executor.add_node(node)
        self._stack.callback(node.destroy_node)
        self._stack.callback(self._executor.remove_node, node)
        return node

    def start_world(self, swarm: SwarmSettings = POND, hosts: int = 0) -> None:
        self.world = self.node("world")
        self.sender = PerceptSender(self.world, KEEPERS, hosts=hosts)

        def take(agent: str, sequence: int, answer: Any, **more: Any) -> None:
            self.answered.add(agent)

        self.sender.join(take, swarm, self.refused.append)

    def keeper(self, name: str) -> None:
        """Start an agent with a process of its own."""
        node = self.node(name)
        actions = node.create_publisher(msg.Action, f"/world/{names.ACTIONS}", qos.CYCLE)

        def answer(percept: msg.Percept) -> None:
            self.heard[name] = name
            actions.publish(msg.Action(agent=name, sequence=percept.sequence))

        node.create_subscription(msg.Percept, names.PERCEPT, answer, qos.CYCLE)

    def host(self, name: str, *agents: str, acts_for: int = 0, **roster: Any) -> GuardedNode:
        """Start a host that answers; ``acts_for`` agents even if it gets no percept of them."""
        node = self.node(name)
        listed = list(agents or KEEPERS)
        actions = node.create_publisher(
            msg.ActionBatch, f"/world/{names.ACTION_BATCHES}", qos.CYCLE
        )

        def answer(batch: msg.PerceptBatch) -> None:
            self.heard |= {listed[index]: name for index in batch.agents}
            indices = array("I", range(acts_for) if acts_for else batch.agents)
            actions.publish(
                msg.ActionBatch(
                    host=name,
                    roster=batch.roster,
                    sequence=batch.sequence,
                    agents=indices,
                    value_counts=[0] * len(indices),
                )
            )

        node.create_subscription(msg.PerceptBatch, names.PERCEPTS, answer, qos.CYCLE)
        if "machine" in roster:
            node.create_subscription(
                msg.PerceptBatch,
                names.PERCEPT_PIECES,
                answer,
                qos.PIECES,
                read=PieceReader(msg.PerceptBatch),
            )
        rosters = node.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
        given = {"number": 1, "swarm": "pond-1", **roster}
        rosters.publish(msg.HostRoster(host=name, agents=listed, **given))
        return node

    def play(self) -> None:
        self._sequence += 1
        self.sender.look()
        common = {"stamp": time_of(0.0), "sequence": self._sequence, "cycle": 1, "episode": 1}
        common |= {"seed": 1, "look": False, "lockstep": False, "restart": False, "back": False}
        self.sender.send(common, lambda agent: ([1.0], []))

    def until(self, condition: Any) -> None:
        """Play until a condition holds."""
        spin_until(self._executor, condition, self.play)

    def plays_with(self, **expected: str) -> None:
        """Wait until each agent's percepts go where they should, and stay there."""
        for _ in range(3):
            self.heard.clear()
            self.until(lambda: self.heard.keys() >= expected.keys())
            if self.heard == expected:
                return
        assert self.heard == expected

    @property
    def faults(self) -> str:
        return "; ".join(self.world.guard.faults.texts())


@pytest.fixture
def swarm() -> Iterator[Swarm]:
    with context_of_its_own() as context, Swarm(context) as swarm:
        yield swarm


def test_a_roster_takes_no_agents_from_their_processes_and_is_refused_by_name(swarm):
    swarm.start_world()
    for name in KEEPERS:
        swarm.keeper(name)
    alone = {name: name for name in KEEPERS}
    swarm.plays_with(**alone)
    evil = swarm.host("evil", number=10**9, acts_for=3)
    swarm.until(lambda: evil.count_publishers("/evil/percepts"))
    swarm.until(lambda: swarm.world.guard.faults)
    swarm.plays_with(**alone)
    assert swarm.faults == (
        "the host evil lists keeper_1, keeper_2, keeper_3, which have processes of their own: "
        "refused; end evil"
    )


def test_a_roster_takes_no_agents_from_a_host_that_listens(swarm):
    swarm.start_world(hosts=1)
    swarm.host("host_of_keeper_1", *KEEPERS[:2], number=100)
    swarm.host("host_of_keeper_3", KEEPERS[2], number=101)
    held = dict.fromkeys(KEEPERS[:2], "host_of_keeper_1") | {"keeper_3": "host_of_keeper_3"}
    swarm.plays_with(**held)
    # Not even with an earlier start: the host has answered.
    swarm.host("evil", "keeper_1", "keeper_3", number=1, acts_for=2)
    swarm.until(lambda: swarm.world.guard.faults)
    swarm.plays_with(**held)
    assert swarm.faults == (
        "the host evil lists keeper_1, which host_of_keeper_1 runs: refused; end one of the two; "
        "the host evil lists keeper_3, which host_of_keeper_3 runs: refused; end one of the two"
    )
    assert swarm.sender.hosts == 2


@pytest.mark.parametrize("alone", [True, False])
def test_a_hostile_roster_before_the_world_starts_takes_nothing(swarm, alone):
    swarm.host("evil", number=10**9)
    if alone:
        for name in KEEPERS:
            swarm.keeper(name)
    else:
        swarm.host("host_of_keeper_1", number=100)
    swarm.start_world()
    swarm.until(lambda: swarm.world.guard.faults)
    expected = {name: name if alone else "host_of_keeper_1" for name in KEEPERS}
    swarm.until(lambda: swarm.heard == expected)
    swarm.plays_with(**expected)
    assert "the host evil lists" in swarm.faults


def test_actions_count_only_for_the_agents_that_a_host_holds(swarm):
    swarm.start_world(hosts=2)
    swarm.host("host_of_keeper_1", "keeper_1", number=1)
    swarm.host("greedy", "keeper_2", "keeper_1", number=2, acts_for=2)
    swarm.plays_with(keeper_1="host_of_keeper_1", keeper_2="greedy")
    swarm.until(lambda: swarm.answered >= {"keeper_1", "keeper_2"})
    taken = []
    swarm.sender._hosts._take = lambda agent, *_, **more: taken.append(agent)
    swarm.sender._hosts._on_actions(
        msg.ActionBatch(host="greedy", roster=2, agents=[0, 1], value_counts=[0, 0])
    )
    assert taken == ["keeper_2"]


@pytest.mark.parametrize("order", [(1, 2), (2, 1)])
def test_a_newer_lease_takes_the_agents_and_an_old_one_that_comes_back_is_refused(swarm, order):
    swarm.start_world(MACHINES, hosts=1)
    leases = {1: ("old", "lab_1", 10**9), 2: ("new", "lab_3", 5)}
    for lease in order:
        name, machine, number = leases[lease]
        swarm.host(name, machine=machine, lease=lease, number=number)
        swarm.until(lambda: swarm.sender.has("keeper_1"))
    swarm.until(lambda: swarm.world.guard.faults)
    swarm.plays_with(**dict.fromkeys(KEEPERS, "new"))
    assert swarm.faults == (
        "the host old lists keeper_1, keeper_2, keeper_3, which new runs on lab_3 (lease 2): "
        "refused, since it has lease 1; it should yield by itself, else end old"
    )


def test_a_roster_without_a_host_takes_no_agents_whatever_its_lease(swarm):
    swarm.start_world(MACHINES, hosts=1)
    swarm.host("host", machine="lab_2", lease=3)
    held = dict.fromkeys(KEEPERS, "host")
    swarm.plays_with(**held)
    stray = swarm.node("stray")
    rosters = stray.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    claim = {"agents": [*KEEPERS], "swarm": "pond-1", "machine": "lab_1", "lease": 99}
    rosters.publish(msg.HostRoster(host="stray", number=9, **claim))
    swarm.until(lambda: stray.count_publishers("/stray/percepts"))
    swarm.plays_with(**held)


def test_of_equal_leases_the_machine_whose_name_comes_first_stays(swarm):
    swarm.start_world(MACHINES, hosts=1)
    swarm.host("second", machine="lab_2", lease=3, number=10**9)
    swarm.plays_with(**dict.fromkeys(KEEPERS, "second"))
    swarm.host("first", machine="lab_1", lease=3)
    swarm.until(lambda: swarm.world.guard.faults)
    swarm.plays_with(**dict.fromkeys(KEEPERS, "first"))


@pytest.mark.parametrize(
    ("settings", "roster", "why"),
    [
        (
            MACHINES,
            {"machine": "lab_9", "lease": 99},
            "it is of the machine lab_9, not of lab_1, lab_2, lab_3; end it, or start it with the "
            "name of one as -p machine",
        ),
        (
            MACHINES,
            {},
            "it is of no machine, not of lab_1, lab_2, lab_3; end it, or start it with the name "
            "of one as -p machine",
        ),
        (
            POND,
            {"machine": "lab_1", "lease": 99},
            "it has the lease 99 of the machine lab_1, and this world's swarm has no machines; "
            "end it, or start it without -p machine, -p lease",
        ),
    ],
)
def test_a_roster_of_a_machine_that_the_swarm_does_not_have_is_refused(
    swarm, settings, roster, why
):
    swarm.start_world(settings, hosts=1)
    own = {"machine": "lab_1", "lease": 1} if settings is MACHINES else {}
    swarm.host("ours", "keeper_1", **own)
    swarm.plays_with(keeper_1="ours")
    swarm.host("evil", "keeper_1", number=10**9, **roster)
    swarm.until(lambda: swarm.refused)
    assert swarm.refused == [f"refused the host evil, which lists keeper_1: {why}"]
    swarm.plays_with(keeper_1="ours")
