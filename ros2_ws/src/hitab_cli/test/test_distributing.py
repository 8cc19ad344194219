"""A distribution waits as long as receivers answer, and not for a fixed time."""

from collections.abc import Iterator
from typing import Any

import pytest
from hitab_msgs import msg, srv
from rclpy.clock import Clock, ClockType

from hitab_client import domain_ids
from hitab_client.connecting.ros_link import RosLink
from hitab_client.swarm_client import SwarmClient
from hitab_core.operations import Distribute
from hitab_ros import names, qos

PUPILS = [f"pupil_{number}" for number in range(4)]
SEQUENCE = 7
DIGEST = "d"


class Swarm:
    """A source, and receivers that acknowledge one after the other."""

    def __init__(self, link: RosLink, period: float, answering: list[str]) -> None:
        self._node = link.node
        self._period = period
        self._waiting = list(answering)
        self._statuses = []
        for name in ("source", *PUPILS):
            status = self._node.create_publisher(
                msg.AgentStatus, f"/{name}/{names.STATUS}", qos.LATCHED
            )
            status.publish(msg.AgentStatus(agent=name))
            self._statuses.append(status)
        self._acks = self._node.create_publisher(
            msg.DistributionAck, f"/{names.DISTRIBUTION_ACK}", qos.ROLL_CALL
        )
        self._node.create_service(srv.Distribute, f"/source/{Distribute.name}", self._distribute)

    def _distribute(self, request: Any, response: Any) -> Any:
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self._node.create_timer(self._period, self._acknowledge, clock=clock)
        response.success, response.sequence, response.digest = True, SEQUENCE, DIGEST
        return response

    def _acknowledge(self) -> None:
        if self._waiting:
            agent = self._waiting.pop(0)
            self._acks.publish(
                msg.DistributionAck(sequence=SEQUENCE, agent=agent, success=True, digest=DIGEST)
            )


@pytest.fixture
def link() -> Iterator[RosLink]:
    with domain_ids.reserved() as number, RosLink(number) as link:
        yield link


def test_it_waits_as_long_as_one_more_answers(link):
    Swarm(link, 1.0, PUPILS)
    reported: list[tuple[int, int]] = []
    client = SwarmClient(link, ["source", *PUPILS])
    # All take longer than that together, and each one takes less.
    report = client.distribute(
        "source",
        Distribute("Go"),
        seconds=3.0,
        progress=lambda done, total: reported.append((done, total)),
    )
    assert (report.accepted, report.silent) == (PUPILS, [])
    assert reported == [(done, len(PUPILS)) for done in range(len(PUPILS) + 1)]


def test_it_does_not_wait_for_ever_for_those_who_never_answer(link):
    Swarm(link, 0.02, PUPILS[:-1])
    client = SwarmClient(link, ["source", *PUPILS])
    report = client.distribute("source", Distribute("Go"), seconds=1.0)
    assert (report.accepted, report.silent) == (PUPILS[:-1], PUPILS[-1:])
