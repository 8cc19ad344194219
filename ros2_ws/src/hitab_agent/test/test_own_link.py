"""A robot whose link is its user's own, without a relay, stands still when it has to."""

from __future__ import annotations

from typing import Any

import pytest
from bodies import Body
from hitab_msgs import msg, srv

from hitab_agent.node.agent_node import AgentNode
from hitab_core import BasicBehavior, Domain, Feature, HitabError, Term
from hitab_core.training import Curriculum
from hitab_ros import EmergencySwitch, give_signs_of_operator, names, qos
from hitab_ros.messages.conversions import pairs_message


class Ahead(Body):
    """A body that drives ahead."""

    action = (1.0,)


class Link:
    """A link that ignores stops and carries out every action."""

    def __init__(self, node: AgentNode, world: str, on_percept: Any) -> None:
        self.on_percept = on_percept

    def close(self) -> None:
        pass


class Robot:
    """One robot with its agent, driven by the test."""

    def __init__(self, start: Any, **parameters: Any) -> None:
        domain = Domain.of(
            "own",
            "1",
            Ahead,
            behaviors=[
                BasicBehavior("Go"),
                BasicBehavior("Turn"),
                BasicBehavior("Stop", stands_still=True),
            ],
            features=[Feature("X", lambda body: body.x)],
            link=f"{__name__}:Link",
        )
        one = self.one = start(domain, **parameters)
        self.process, self.node, desk = one.process, one.node, one.process.node
        self.states: list[msg.StopState] = []
        topic = f"/one/{names.STOP_STATE}"
        desk.create_subscription(msg.StopState, topic, self.states.append, qos.STREAM)
        self.arming = desk.create_client(srv.Arm, f"/one/{names.ARM}")
        self.switch = EmergencySwitch(desk)
        self.node.agent.perform(Term("Go"))

    def drives(self, x: float = 1.0) -> bool:
        """Whether the link's last action drives."""
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


def test_what_is_commanded_before_it_is_re_armed_is_refused_with_the_way_out(robot):
    one = robot.one
    one.agent.begin(Curriculum("Drive", (Term("X"),)))
    robot.drives()
    one.command("Go")
    assert one.status.last_error.startswith("waits to be armed: it has just started")
    assert [(r.code, r.arguments[0].value) for r in one.status.remedies] == [("ARM", "one")]
    assert (one.status.armed, one.status.stopped != "") == (False, True)
    assert one.agent.session.examples == ()
    one.command("Stop")
    assert one.agent.active_path == ["Stop"], "that it can do"
    assert robot.arm() == ""
    one.command("Go")
    assert one.status.last_error == ""
    assert one.agent.active_path == ["Go"]


def test_a_robot_out_of_reach_halts_if_it_is_to_and_drives_only_once_re_armed(start):
    robot = Robot(start, when_out_of_reach="halt", out_of_reach_after=1.0)
    assert robot.one.status.when_out_of_reach == "halt"
    assert robot.arm() == ""
    assert robot.drives(), "a console that was never there is not lost"
    there = [True]
    give_signs_of_operator(robot.process.node, "", lambda: there)
    robot.process.until(lambda: robot.node.count_publishers(f"/{names.OPERATORS}"))
    robot.process.meanwhile(ticks := [])
    robot.process.until(lambda: len(ticks) > 300)
    assert robot.drives()
    there.clear()
    robot.process.until(lambda: not robot.drives())
    assert "the operator is out of reach: silent since " in robot.one.faults
    assert "out of reach" in robot.arm()
    there.append(True)
    robot.process.until(lambda: robot.drives() or "that is over" in robot.one.faults)
    assert not robot.drives()
    assert robot.arm() == ""
    assert robot.drives()


@pytest.mark.parametrize("first", ["stop", "order"])
def test_an_order_that_comes_late_with_a_stop_moves_nothing_until_the_robot_is_re_armed(
    start, first
):
    """As after a cut of the link, when all that was sent meanwhile arrives in any order."""
    robot = Robot(start, commander="chief")
    desk, agent = robot.process.node, robot.node.agent
    orders = desk.create_publisher(msg.Order, f"/chief/{names.ORDER}", qos.LATCHED)
    robot.process.until(orders.get_subscription_count)
    assert robot.arm() == ""
    assert robot.drives()

    def order(number: int, behavior: str) -> None:
        meant = pairs_message([("", behavior)])
        numbered = {"epoch": 1, "sequence": number}
        orders.publish(msg.Order(commander="chief", order=behavior, behaviors=meant, **numbered))

    def stop() -> None:
        robot.switch.set(True, "ann", "a dog")

    for send in [stop, lambda: order(1, "Turn")][:: 1 if first == "stop" else -1]:
        send()
    robot.process.until(lambda: robot.node.stop.is_emergency and agent.behavior == "Turn")
    assert not robot.drives()
    order(2, "Go")
    robot.process.until(lambda: agent.behavior == "Go")
    assert not robot.drives()
    assert "by ann (a dog)" in robot.arm()
    robot.switch.set(False, "ann")
    robot.process.until(lambda: not robot.states[-1].causes)
    order(3, "Turn")
    robot.process.until(lambda: agent.behavior == "Turn")
    assert not robot.drives(), "a released stop is no order to move"
    assert robot.arm() == ""
    assert robot.drives()
    assert agent.behavior == "Turn", "the newest order"


def test_what_is_to_happen_out_of_reach_is_one_of_two_things(start):
    with pytest.raises(HitabError, match='"stop"; it must be go_on or halt'):
        Robot(start, when_out_of_reach="stop")
