"""A basic behavior may be an action: its server performs it, and its end raises a flag.

The server here is the tests' own; hitab_msgs/action/Perform stands for a robot's action.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from threading import Thread
from typing import Any

import pytest
from bodies import Body
from diagnostic_msgs.msg import DiagnosticStatus
from hitab_msgs.action import Perform
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import SingleThreadedExecutor
from rclpy.task import Future

from hitab_agent.actions.action_clients import ActionClients, check_actions
from hitab_agent.actions.goal import Limits
from hitab_agent.node.restart_memory import RestartMemory
from hitab_core import (
    START,
    ActionBehavior,
    Automaton,
    BasicBehavior,
    Domain,
    Feature,
    HandWritten,
    HitabError,
    Target,
    Term,
    calls_of,
    feedback_feature,
)
from hitab_ros import GuardedNode, qos
from hitab_ros.testing import wait_until

KIND = "hitab_msgs/action/Perform"
PLACES = {"home": "the hut", "away": "the hill"}


def domain(**changes: Any) -> Domain:
    go = ActionBehavior(
        "GoTo",
        parameters=("X",),
        action_type=KIND,
        action="drive",
        **{"goal": {"behavior": lambda body, place: place, "targets": ["slowly"]}, **changes},
    )
    choose = HandWritten(
        lambda x, done, failed: (
            "Rest" if done else "Cry" if failed else "GoTo(home)" if x else "Rest"
        ),
        (0, 1, 2),
    )
    stay = HandWritten(lambda x, done, failed: "Rest" if x < 0 else "GoTo(home)", (0, 1, 2))
    return Domain.of(
        "walkers",
        "1",
        Body,
        behaviors=[go, BasicBehavior("Rest"), BasicBehavior("Cry")],
        features=[
            Feature("X", lambda body: body.x),
            feedback_feature("Steps", "GoTo", "cycle"),
            feedback_feature("Depth", "GoTo", "active_path", len, otherwise=0.0),
        ],
        targets=[Target(place, lambda body, told=told: told) for place, told in PLACES.items()],
        automata=[
            Automaton(
                name,
                (Term("GoTo", ("home",)), Term("Rest"), Term("Cry")),
                (Term("X"), Term("Done"), Term("Failed")),
                dict.fromkeys((START, "GoTo(home)"), function) | {"Rest": choose},
            )
            for name, function in (("Walk", choose), ("Stay", stay))
        ],
    )


class Robot:
    """A robot's own action server, which does what the test says, in a thread of its own.

    Attributes:
        goals: the handles of all accepted goals, in order.
    """

    def __init__(self, context: Any) -> None:
        self.goals: list[Any] = []
        self.accepts = self.cancels = True
        self._endings: list[Future] = []
        self._node = GuardedNode("robot", context=context)
        self._server = ActionServer(
            self._node,
            Perform,
            "/one/drive",
            self._execute,
            goal_callback=lambda goal: (
                GoalResponse.ACCEPT if self.accepts else GoalResponse.REJECT
            ),
            cancel_callback=lambda handle: (
                CancelResponse.ACCEPT if self.cancels else CancelResponse.REJECT
            ),
        )
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)
        self._is_up = True
        self._thread = Thread(target=self._spin)
        self._thread.start()

    def _spin(self) -> None:
        while self._is_up:
            self._executor.spin_once(timeout_sec=0.1)

    async def _execute(self, handle: Any) -> Any:
        ending: Future = Future(executor=self._executor)
        self.goals.append(handle)
        self._endings.append(ending)
        how, result = await ending
        getattr(handle, how)()
        return result

    def end(self, number: int, how: str, **fields: Any) -> None:
        """End a goal: ``succeed``, ``abort`` or ``canceled``."""
        self._endings[number].set_result((how, Perform.Result(**fields)))

    def close(self) -> None:
        """Go away."""
        if self._is_up:
            self._is_up = False
            self._thread.join()
            self._server.destroy()
            self._executor.shutdown()
            self._node.destroy_node()


@pytest.fixture
def serve(process: Any) -> Iterator[Callable[[], Robot]]:
    robots: list[Robot] = []

    def served() -> Robot:
        robots.append(Robot(process.node.context))
        return robots[-1]

    yield served
    for robot in robots:
        robot.close()


@pytest.fixture
def make(start: Any, serve: Callable[[], Robot]) -> Any:
    def made(alone: bool = False, kind: Domain | None = None, **parameters: Any) -> Any:
        given = {"action_timeout": 30.0, "action_patience": 0.0, **parameters}
        return start(kind or domain(), **given), None if alone else serve()

    return made


@pytest.fixture
def going(make: Any) -> Any:
    """One that performs what a test says, whose server has taken the goal."""

    def gone(term: Term, **more: Any) -> Any:
        one, server = make(**more)
        one.agent.perform(term)
        one.perceive()
        one.process.until(lambda: server.goals and call_of(one).accepted)
        return one, server

    return gone


def call_of(one: Any) -> Any:
    return calls_of(one.body).current


def perceives_until(one: Any, *path: str) -> None:
    one.process.until(lambda: one.perceive() == [*path])


WALK, STAY, HOME = Term("Walk"), Term("Stay"), Term("GoTo", ("home",))


def test_entering_sends_the_goal_and_success_raises_done(going):
    one, server = going(WALK)
    assert server.goals[0].request == Perform.Goal(behavior="the hut", targets=["slowly"])
    assert one.perceive() == ["GoTo(home)"]
    server.end(0, "succeed")
    perceives_until(one, "Rest")
    assert len(server.goals) == 1
    assert one.faults == ""


def test_a_goal_that_the_server_aborts_raises_failed_and_the_status_says_why(going):
    one, server = going(WALK)
    server.end(0, "abort", message="the door is shut")
    perceives_until(one, "Cry")
    one.process.until(lambda: one.status.faults)
    told = f'one: "GoTo(home)" failed: /one/drive ({KIND}) aborted the goal '
    assert one.status.faults[0].startswith(told)
    assert "the door is shut" in one.status.faults[0]
    one.agent.perform(Term("Rest"))  # what is past is no fault
    one.node.status.publish()
    assert one.faults == ""


def test_a_goal_that_the_server_rejects_raises_failed(make):
    one, server = make()
    server.accepts = False
    one.agent.perform(Term("Walk"))
    perceives_until(one, "Cry")
    assert "rejected the goal" in one.faults


def test_leaving_cancels_the_goal(going):
    one, server = going(STAY)
    assert one.perceive(-1.0) == ["Rest"]
    one.process.until(lambda: server.goals[0].is_cancel_requested)
    server.end(0, "canceled")
    assert one.faults == ""


def test_a_goal_that_is_left_before_the_server_has_answered_is_canceled_then(make):
    one, server = make()
    one.agent.perform(HOME)
    one.process.until(lambda: one.perceive() == [] and server.goals)
    one.agent.perform(None)
    one.process.until(lambda: server.goals[0].is_cancel_requested)


def test_a_late_result_of_the_old_goal_says_nothing_of_the_new_one(make):
    one, server = make()
    server.cancels = False  # it goes on with what was canceled
    one.agent.perform(HOME)
    one.perceive()
    one.process.until(lambda: server.goals)
    one.perceive()
    one.agent.perform(Term("GoTo", ("away",)))
    one.perceive()
    one.process.until(lambda: len(server.goals) == 2)
    server.end(0, "succeed")
    seen: list[Any] = []
    server.goals[1].publish_feedback(Perform.Feedback(cycle=7))
    one.process.until(lambda: call_of(one).feedback)
    one.process.meanwhile(seen)
    one.process.until(lambda: len(seen) > 20)
    one.perceive()
    assert one.agent.raised == frozenset()
    server.end(1, "succeed")
    one.process.until(lambda: one.perceive() == [] and one.agent.raised == {"Done"})


def test_a_server_gets_the_next_goal_when_it_has_ended_the_canceled_one(going):
    one, server = going(HOME)
    one.agent.perform(Term("GoTo", ("away",)))
    one.perceive()
    one.process.until(lambda: server.goals[0].is_cancel_requested)
    one.perceive()
    assert len(server.goals) == 1
    server.end(0, "canceled")
    one.process.until(lambda: len(server.goals) == 2)
    assert server.goals[1].request.behavior == "the hill"
    assert one.faults == ""


def test_the_absence_of_a_server_raises_failed_after_a_while(make):
    one, _ = make(alone=True, action_timeout=0.3)
    one.agent.perform(Term("Walk"))
    assert one.perceive() == ["GoTo(home)"]
    perceives_until(one, "Cry")
    assert f"/one/drive ({KIND}) has no server: none appeared within 0.3 s" in one.faults


def test_a_server_that_comes_late_gets_the_goal(make, serve):
    one, _ = make(alone=True)
    one.agent.perform(Term("Walk"))
    one.perceive()
    one.perceive()
    server = serve()
    one.process.until(lambda: server.goals)


def test_a_server_that_dies_raises_failed(going):
    one, server = going(WALK)
    one.perceive()
    server.close()
    perceives_until(one, "Cry")
    assert f"/one/drive ({KIND}) has no server any more" in one.faults


def test_a_server_that_hangs_is_noticed_by_its_silence(going):
    one, _ = going(WALK, kind=domain(feedback_within=0.3))
    perceives_until(one, "Cry")
    assert "gave no feedback for 0.3 s" in one.faults


def test_an_agent_that_does_not_act_any_more_cancels_its_goal(going):
    one, server = going(HOME, action_patience=0.3)
    one.process.until(lambda: server.goals[0].is_cancel_requested)
    assert "has not acted for 0.3 s" in one.faults


def test_feedback_is_a_feature_of_the_state_that_it_belongs_to(make):
    one, server = make()
    steps = one.agent.domain.features["Steps"].read
    depth = one.agent.domain.features["Depth"].read
    body = one.agent.body
    with pytest.raises(HitabError, match='there is no feedback of "GoTo"'):
        steps(body)
    assert depth(body) == 0.0
    one.agent.perform(HOME)
    one.perceive()
    one.process.until(lambda: server.goals)
    server.goals[0].publish_feedback(Perform.Feedback(cycle=3, active_path=["a", "b"]))
    one.process.until(lambda: call_of(one).feedback)
    assert (steps(body), depth(body)) == (3.0, 2.0)
    one.agent.perform(Term("Rest"))
    assert depth(body) == 0.0


class Held:
    """The stop of a robot, as its link would set it."""

    why = ""
    is_emergency = True

    def cause(self, why: str) -> None:
        pass


def hold(one: Any, why: str) -> None:
    if one.node.stop is None:
        one.node.stop = Held()
    one.node.stop.why = why
    one.node.stop_changed()


def test_which_goals_the_servers_have_is_told_for_the_relay_until_they_are_done(going):
    one, server = going(HOME)
    told: list[Any] = []

    def hear(message: DiagnosticStatus) -> None:
        told.append([(goal.key, goal.value) for goal in message.values])

    one.process.node.create_subscription(DiagnosticStatus, "/one/agent_goals", hear, qos.LATCHED)
    identity = bytes(server.goals[0].goal_id.uuid).hex()
    one.process.until(lambda: told and told[-1] == [("/one/drive", identity)])
    server.end(0, "succeed")
    one.process.until(lambda: told[-1] == [])


def test_a_stop_cancels_the_goal_and_it_is_sent_anew_once_the_robot_is_re_armed(going):
    one, server = going(STAY)
    hold(one, "stopped: a dog")
    assert not one.node.stands()
    one.process.until(lambda: server.goals[0].is_cancel_requested)
    server.end(0, "canceled")
    one.process.until(one.node.stands)
    assert one.perceive() == ["GoTo(home)"], "the agent goes on wanting it"
    assert "a dog" in one.faults
    hold(one, "")
    one.process.until(lambda: len(server.goals) == 2)
    server.end(1, "succeed")
    one.process.until(lambda: call_of(one).outcome)
    assert one.faults == ""


def test_a_server_that_refuses_to_cancel_is_named_and_the_robot_does_not_stand_still(make):
    one, server = make()
    server.cancels = False
    one.agent.perform(Term("Stay"))
    one.perceive()
    one.process.until(lambda: server.goals and call_of(one).accepted)
    hold(one, "stopped: a dog")
    one.process.until(lambda: "/one/drive" in one.faults and "refuses to cancel" in one.faults)
    assert not one.node.stands()
    server.end(0, "abort")
    one.process.until(one.node.stands)
    assert "refuses" not in one.faults


def test_a_goal_of_an_agent_that_was_killed_is_canceled_when_it_is_back(going, process, tmp_path):
    one, server = going(STAY)
    noted = one.node.memory.values["goals"]
    assert bytes.fromhex(noted[0][1]) == bytes(server.goals[0].goal_id.uuid)
    # The next process takes over, while the first one does nothing any more.
    memory = RestartMemory(tmp_path, "next", "")
    memory.keep({"goals": [*noted, ["drive", "x"], 3, ["drive", "00"]]})
    limits = Limits(answer=30.0, pulse=0.0)
    clients = ActionClients(one.node, one.agent, one.node.scheduler, limits, memory)
    assert not clients.at_rest
    process.until(lambda: server.goals[0].is_cancel_requested)
    server.end(0, "canceled")
    process.until(lambda: clients.at_rest)
    assert memory.values["goals"] == []


def test_an_agent_that_ends_cancels_its_goal(make, process):
    one, server = make()
    one.agent.perform(HOME)
    one.perceive()
    process.until(lambda: server.goals)
    process.until(lambda: call_of(one).accepted)
    process.close()
    wait_until(lambda: server.goals[0].is_cancel_requested)


def test_what_is_mistyped_is_refused_at_the_start_with_its_place():
    for changes, told in [
        ({"action_type": "hitab_msgs/Perform"}, "not of the form"),
        ({"action_type": "no_such_msgs/action/Go"}, "install the package no_such_msgs"),
        ({"action_type": "hitab_msgs/action/Preform"}, 'Did you mean "Perform"'),
        ({"goal": {"behaviour": "x"}}, 'Did you mean "behavior"'),
        ({"goal": {"behavior": 1}}, '"behavior" cannot be 1: '),
        ({"goal": {"behavior.name": "x"}}, "is not a message with fields"),
        ({"goal": {"targets": "home"}}, "it must be a list"),
        ({"action": ""}, "it has no action"),
    ]:
        whole = domain()
        go = whole.behaviors["GoTo"]
        given = {"action_type": KIND, "action": "drive", "goal": {}, **changes}
        wrong = ActionBehavior("GoTo", parameters=go.parameters, **given)
        with pytest.raises(HitabError) as refused:
            check_actions(
                Domain.of("walkers", "1", Body, behaviors=[wrong], features=[], targets=[])
            )
        assert str(refused.value).startswith('domain "walkers": behavior "GoTo": ')
        assert told in str(refused.value)


@pytest.mark.parametrize(
    ("feature", "told"),
    [
        (feedback_feature("Steps", "GoTo", "cycles"), 'Did you mean "cycle"'),
        (feedback_feature("Steps", "Goto", "cycle"), 'Did you mean "GoTo"'),
        (feedback_feature("Steps", "GoTo", "active_path"), "is not a number; give value="),
    ],
)
def test_feedback_that_is_mistyped_is_refused_at_the_start_with_its_place(feature, told):
    go = ActionBehavior("GoTo", action_type=KIND, action="drive")
    with pytest.raises(HitabError) as refused:
        check_actions(Domain.of("walkers", "1", Body, behaviors=[go], features=[feature]))
    assert str(refused.value).startswith('domain "walkers": feature "Steps": ')
    assert told in str(refused.value)


def test_an_agent_without_actions_does_not_load_them():
    loaded = "import sys, hitab_agent.node.agent_node; print('rclpy.action' in sys.modules)"
    assert subprocess.check_output([sys.executable, "-c", loaded], text=True) == "False\n"
