"""A robot whose link is its user's own, without a relay, stands still when it has to."""

from __future__ import annotations

from typing import Any

import pytest
from hitab_msgs import msg, srv

from hitab_agent.agent_node import AgentNode
from hitab_core import BasicBehavior, Domain, Feature, Use
from hitab_ros import EmergencySwitch, names, qos
from hitab_ros.testing import NumberBody


class Body(NumberBody):
    """A body that drives ahead."""

    def act(self) -> tuple[list[float], str]:
        """Drive ahead."""
        return [1.0], ""


class Link:
    """Knows nothing of stops: it drives as it is told."""

    def __init__(self, node: AgentNode, world: str, on_percept: Any) -> None:
        self.on_percept = on_percept

    def close(self) -> None:
        pass


class Robot:
    """One robot with its agent, driven by the test."""

    def __init__(self, start: Any) -> None:
        domain = Domain.of(
            "own",
            "1",
            Body,
            behaviors=[BasicBehavior("Go")],
            features=[Feature("X", lambda body: body.x)],
            link=f"{__name__}:Link",
        )
        one = start(domain)
        self.process, self.node, desk = one.process, one.node, one.process.node
        self.states: list[msg.StopState] = []
        topic = f"/one/{names.STOP_STATE}"
        desk.create_subscription(msg.StopState, topic, self.states.append, qos.STREAM)
        self.arming = desk.create_client(srv.Arm, f"/one/{names.ARM}")
        self.switch = EmergencySwitch(desk)
        self.node.agent.perform(Use("Go"))

    def drives(self, x: float = 1.0) -> bool:
        """Whether the link is told to drive."""
        return bool(self.node._link.on_percept(msg.Percept(values=[x]))[0])

    def arm(self) -> str:
        self.states.clear()
        self.process.until(lambda: self.states and self.states[-1].state == msg.StopState.STOPPED)
        answer = self.arming.call_async(srv.Arm.Request(stop=self.states[-1].stop))
        self.process.until(answer.done)
        return str(answer.result().message)


@pytest.fixture
def robot(start):
    return Robot(start)


def test_it_drives_only_once_re_armed_after_its_start_and_after_a_stop(robot):
    assert not robot.drives()
    assert robot.arm() == ""
    assert robot.drives()
    robot.switch.set(True, "ann", "a dog")
    robot.process.until(lambda: not robot.drives())
    assert any("by ann (a dog)" in fault for fault in robot.node.status.faults)
    assert "by ann (a dog)" in robot.arm()
    robot.switch.set(False, "ann")
    robot.process.until(lambda: not robot.states[-1].causes)
    assert not robot.drives()
    assert robot.arm() == ""
    assert robot.drives()


def test_an_agent_that_could_not_act_acts_only_once_re_armed(robot, monkeypatch):
    assert robot.arm() == ""
    assert robot.drives()
    monkeypatch.setattr(robot.node.agent.body, "act", lambda: 1 / 0)
    assert not robot.drives()
    monkeypatch.undo()
    assert not robot.drives()
    assert robot.arm() == ""
    assert robot.drives()
