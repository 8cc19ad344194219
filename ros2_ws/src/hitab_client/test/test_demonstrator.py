"""Outcomes of keys and buttons, with agents played by the test."""

from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus, Behavior, Number, TrainingStatus, WorldState, WorldStatus
from sensor_msgs.msg import Joy

from hitab_client import SwarmError
from hitab_client.demonstrating import Demonstrator, KeyboardInput
from hitab_client.demonstrating.demonstrator import KEY_AGE_MAX_S, PENDING_MAX
from hitab_client.demonstrating.keyboard import HOLD_S
from hitab_core import BoundedNumber
from hitab_core.operations import Command, Perform, TakeOver, Test, Undo
from hitab_core.training.operation import Operation
from hitab_gamepad import JoystickInput, read_mapping
from hitab_ros.call import Caller, blocking
from hitab_ros.messages.conversions import message_of
from hitab_ros.timing import FOUND_S

ONE, TWO = "robot_1", "robot_2"
NUMBERS = [
    BoundedNumber("direction", -180.0, 180.0, "deg", circular=True),
    BoundedNumber("power", 0.0, 50.0),
]


class Topic:
    """A publisher whose number of subscribers the test sets."""

    def __init__(self, name: str, listeners: list[int]) -> None:
        self.topic_name = name
        self.sent: list[Any] = []
        self.get_subscription_count = lambda: listeners[0]

    def publish(self, message: Any) -> None:
        self.sent.append(message)


class Node:
    """A node whose timers the test fires."""

    def __init__(self) -> None:
        self.topics: dict[str, Topic] = {}
        self.timers: list[Any] = []
        self.subscriptions: dict[str, Any] = {}
        self.listeners = [1]

    def get_name(self) -> str:
        return "person"

    def create_publisher(self, kind: Any, topic: str, qos: Any, **options: Any) -> Topic:
        self.topics[topic] = Topic(topic, self.listeners)
        return self.topics[topic]

    def create_timer(self, period: float, callback: Any, clock: Any) -> None:
        self.timers.append(callback)

    def create_subscription(
        self, kind: Any, topic: str, callback: Any, *_: Any, **__: Any
    ) -> None:
        self.subscriptions[topic] = callback

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        return []

    def destroy_publisher(self, topic: Topic) -> None:
        pass

    def get_fully_qualified_name(self) -> str:
        return "/hitab"

    def get_subscriptions_info_by_topic(self, topic: str) -> list[Any]:
        return []

    def get_clock(self) -> Any:
        stamp = WorldStatus().stamp
        return SimpleNamespace(now=lambda: SimpleNamespace(to_msg=lambda: stamp))


class Agents:
    """A swarm client whose agents carry out each request at once."""

    prefix = ""
    demonstrator = "ann"
    expected = (ONE, TWO)

    def __init__(self) -> None:
        self.link: Any = Caller(Node())
        self.link.topics_of_type = lambda kind: []
        self.statuses = {name: AgentStatus(agent=name, mode="idle") for name in self.expected}
        self.done: list[Any] = []

    def agents(self) -> list[str]:
        return sorted(self.statuses)

    @blocking
    async def await_agent(self, agent: str) -> AgentStatus:
        return self.statuses[agent]

    def vocabulary(self, agent: str) -> Any:
        behaviors = [Behavior(name=name) for name in ("Forward", "GoTo(A)")]
        behaviors.append(
            Behavior(name="Kick(A)", numbers=[message_of(Number, n) for n in NUMBERS])
        )
        return SimpleNamespace(domain="test", behaviors=behaviors, targets=["goal", "home"])

    def training(self, agent: str) -> Any:
        return SimpleNamespace(
            name="Wander", chosen_states=[], possible_states=[], parameters=["B"]
        )

    @blocking
    async def do(self, agent: str, operation: Operation, **options: Any) -> Any:
        self.done.append((agent, operation))
        match operation:
            case Perform(behavior=behavior):
                self.become(agent, "performing" if behavior else "idle", *filter(None, [behavior]))
            case Command(behavior=behavior):
                self.become(agent, "training", behavior)
            case TakeOver():
                self.become(agent, "training", "Start")
            case Test():
                self.become(agent, "testing", "Start")
        return SimpleNamespace(message=f"{agent} did {operation.name}")

    def become(self, agent: str, mode: str, *path: str) -> None:
        self.statuses[agent] = AgentStatus(
            agent=agent,
            mode=mode,
            active_path=path,
            behavior="Wander",
            training=TrainingStatus(automaton="Wander"),
        )


class Desk:
    """A demonstrator at a clock that the test moves."""

    def __init__(self, *, asks: bool = True) -> None:
        self.now = 100.0
        self.agents = Agents()
        self.world = SimpleNamespace(status=None, state=None, speed=1.0)
        clock = lambda: self.now  # noqa: E731
        world: Any = self.world
        agents: Any = self.agents
        self.demonstrator = Demonstrator(agents, world, asks=asks, clock=clock)
        self.keyboard = KeyboardInput(self.demonstrator, 0.2, 0.8, clock)
        self.demonstrator.choose(ONE)
        self.demonstrator.look()
        self.now += FOUND_S + 1.0

    def press(self, *keys: str) -> str:
        for key in keys:
            self.keyboard.press(key)
            self.demonstrator.work()
            self.ring()
        return self.demonstrator.said

    def ring(self) -> None:
        for timer in self.agents.link.node.timers:
            timer()

    @property
    def driven(self) -> tuple[float, float, float]:
        """The last velocity that the robot's relay received."""
        sent = self.agents.link.node.topics[f"/{ONE}/cmd_vel_teleop"].sent
        if not sent:
            return 0.0, 0.0, 0.0
        twist = sent[-1].twist
        return twist.linear.x, twist.linear.y, twist.angular.z


@pytest.fixture
def desk(tmp_path: Any, monkeypatch: Any) -> Desk:
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    return Desk()


def test_a_behavior_is_commanded_in_training_and_performed_otherwise(desk):
    assert "learns from commands only in training" in desk.press("1")
    assert desk.agents.done == [(ONE, Perform("Forward"))]
    desk.agents.become(ONE, "testing", "Forward")
    assert desk.press("1") == f"{ONE} did command"
    assert desk.agents.done[1:] == [(ONE, TakeOver()), (ONE, Command("Forward", pace=1.0))]


def test_a_command_counts_for_what_was_seen_when_the_key_was_pressed(desk):
    desk.agents.become(ONE, "training", "Start")
    desk.world.status = WorldStatus(mode="running", pace="realtime", factor=2.0)
    desk.world.state = WorldState(cycle=70)
    desk.demonstrator.press_behavior("Forward")
    desk.now += 0.5  # until an agent has answered
    desk.world.state = WorldState(cycle=80)
    desk.demonstrator.work()
    assert desk.agents.done[-1] == (ONE, Command("Forward", seen=70, pace=2.0)), (
        "two simulated seconds in one of the person"
    )
    desk.world.status.mode = "paused"
    desk.press("1")
    waited = Command("Forward", exact=True)
    assert desk.agents.done[-1] == (ONE, waited), "the situation has waited for the person"


def test_what_was_pressed_too_long_ago_or_too_often_is_left_out(desk):
    desk.demonstrator.press_behavior("Forward")
    desk.now += KEY_AGE_MAX_S + 0.1
    desk.demonstrator.work()
    assert "Forward is left out: it was pressed 1.1 s ago" in desk.demonstrator.said
    assert desk.demonstrator.failed
    for _ in range(50):
        desk.demonstrator.press_behavior("Forward")
    desk.demonstrator.work()
    assert len(desk.agents.done) == PENDING_MAX


def test_keys_pressed_before_a_refusal_can_be_seen_are_left_out(desk):
    desk.agents.become(ONE, "training", "Start")
    desk.demonstrator.press_behavior("Forward")
    desk.now += KEY_AGE_MAX_S + 0.1  # while an agent has not answered
    for key in "u1u":
        desk.keyboard.press(key)
    desk.demonstrator.work()
    assert desk.agents.done == [], "an undo would take back the command before"
    assert desk.demonstrator.said == (
        "undo is left out: it was pressed after Forward, which was not taken"
    )
    assert desk.press("1", "u")
    assert desk.agents.done == [(ONE, Command("Forward", pace=1.0)), (ONE, Undo())]


def test_keys_for_another_agent_and_what_stops_are_carried_out_after_a_refusal(desk):
    desk.agents.become(ONE, "performing", "Forward")
    desk.demonstrator.press_behavior("Forward")
    desk.now += KEY_AGE_MAX_S + 0.1
    desk.demonstrator.press("next")
    desk.demonstrator.press_behavior("Forward")
    desk.demonstrator.press("previous")
    desk.demonstrator.steer((0.5, 0.0, 0.0), 0.3)
    desk.demonstrator.work()
    assert desk.agents.done == [(TWO, Perform("Forward")), (ONE, Perform())]


def test_what_is_pressed_is_for_the_agent_that_was_chosen_then(desk):
    desk.demonstrator.press_behavior("Forward")
    desk.demonstrator.press("next")
    desk.demonstrator.press_behavior("Forward")
    desk.demonstrator.work()
    assert [agent for agent, _ in desk.agents.done] == [ONE, TWO]
    desk.press("]")
    assert desk.demonstrator.agent == ONE


def test_a_behavior_with_a_parameter_asks_for_its_target(desk):
    desk.press("2")
    assert desk.demonstrator.prompt.targets == ("goal", "home")
    desk.press("2")
    assert desk.agents.done == [(ONE, Perform("GoTo(home)"))]
    desk.press("2", "x")
    assert desk.demonstrator.prompt is None
    assert len(desk.agents.done) == 1
    desk.agents.become(ONE, "training", "Start")
    desk.press("2", "3")
    assert desk.agents.done[-1][1].behavior == "GoTo(B)", "a parameter of the training"


def test_a_target_may_be_pressed_before_an_agent_has_answered(desk):
    """Otherwise the key of the target would command a behavior."""
    for key in "121":
        desk.keyboard.press(key)
    desk.demonstrator.work()
    assert desk.agents.done == [(ONE, Perform("Forward")), (ONE, Perform("GoTo(goal)"))]


def test_numbers_are_typed_after_the_target(desk):
    desk.agents.become(ONE, "training", "Start")
    desk.press("3", "1")
    assert desk.demonstrator.prompt.number.name == "direction"
    assert "direction of" in desk.press(*"400", "\n")
    assert desk.demonstrator.failed
    desk.press(*"-49", "\x7f", "0", "\n", *"3.5", "\r")
    assert desk.agents.done[-1][1].behavior == "Kick(goal, direction=-40, power=3.5)"
    assert desk.demonstrator.prompt is None
    desk.press("3", "1", "4", "\x1b")
    assert desk.demonstrator.prompt is None
    assert len(desk.agents.done) == 1


class Gamepad:
    """An Xbox gamepad with its switch held, on a topic."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        mapping = read_mapping("xbox").but(behaviors={"A": "Kick(goal)"})
        link: Any = desk.agents.link
        JoystickInput(link, desk.demonstrator, mapping, "joy")
        self.push()
        self.push(held=True)

    def push(self, *axes: float, held: bool = False, button: bool = False) -> None:
        """Send the positions of the right stick (to the left, ahead) and the left one (ahead)."""
        left, ahead, power = axes or (0.0, 0.0, 0.0)
        buttons = [int(button), 0, 0, 0, int(held), *[0] * 6]
        joy = Joy(axes=[0.0, power, 0.0, left, ahead, 0.0, 0.0, 0.0], buttons=buttons)
        self.desk.agents.link.node.subscriptions["joy"](joy)
        self.desk.demonstrator.work()


@pytest.fixture
def gamepad(tmp_path: Any, monkeypatch: Any) -> Gamepad:
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    desk = Desk(asks=False)
    desk.agents.become(ONE, "training", "Start")
    return Gamepad(desk)


def test_a_stick_gives_the_numbers_when_the_button_is_let_go(gamepad):
    desk = gamepad.desk
    gamepad.push(held=True, button=True)
    gamepad.push(0.9, 0.9, 0.5, held=True, button=True)
    assert not desk.agents.done
    assert desk.driven == (0.0, 0.0, 0.0), "the sticks give numbers meanwhile"
    gamepad.push(0.9, 0.9, 0.5, held=True)
    assert desk.agents.done[-1][1].behavior == "Kick(goal, direction=45, power=25)"


def test_a_stick_that_points_nowhere_or_is_lost_commands_nothing(gamepad):
    desk = gamepad.desk
    gamepad.push(held=True, button=True)
    gamepad.push(held=True)
    assert "Kick(goal) is not commanded: the stick gave no direction" in desk.demonstrator.said
    gamepad.push(held=True, button=True)
    gamepad.push(0.9, 0.9, 0.5)  # the switch was let go as well
    gamepad.push(held=True)
    gamepad.push(held=True, button=True)
    desk.agents.link.node.subscriptions["joy"](Joy(axes=[0.0], buttons=[0] * 11))
    gamepad.push(0.9, 0.9, 0.5, held=True)
    assert not desk.agents.done


def test_an_error_is_said_and_the_next_key_counts(desk, monkeypatch):
    async def refuse(*arguments: Any, **options: Any) -> None:
        raise SwarmError("no")

    monkeypatch.setattr(desk.agents, "do", SimpleNamespace(coroutine=refuse))
    assert desk.press("1") == "no"
    assert desk.demonstrator.failed
    monkeypatch.undo()
    desk.press("1")
    assert not desk.demonstrator.failed


def test_an_arrow_key_drives_for_a_moment_and_two_of_them_together(desk):
    desk.press("up")
    assert desk.driven == (0.2, 0.0, 0.0)
    desk.now += HOLD_S / 2
    desk.press("left")
    assert desk.driven == (0.2, 0.0, 0.8)
    desk.now += HOLD_S * 0.75
    desk.press("left")
    assert desk.driven == (0.0, 0.0, 0.8), "the other one was let go"
    desk.press("shift-left")
    assert desk.driven == (0.0, 0.2, 0.8)
    desk.now += HOLD_S + 0.01
    desk.ring()
    assert desk.driven == (0.0, 0.0, 0.0)


def test_an_agent_that_acts_is_halted_before_its_robot_is_driven_and_its_training_kept(desk):
    desk.agents.become(ONE, "testing", "Forward")
    desk.keyboard.press("up")
    desk.ring()
    assert desk.driven == (0.0, 0.0, 0.0)
    desk.demonstrator.work()
    desk.ring()
    assert desk.agents.done == [(ONE, Perform()), (ONE, TakeOver())]
    assert desk.driven == (0.2, 0.0, 0.0)


def test_what_begins_to_act_ends_the_driving_until_the_person_lets_go(desk):
    def deflected(seconds: float = 0.5) -> tuple[float, float, float]:
        desk.demonstrator.steer((0.3, 0.0, 0.0), seconds)
        desk.demonstrator.work()
        desk.ring()
        return desk.driven

    assert deflected() == (0.3, 0.0, 0.0)
    desk.demonstrator.press_behavior("Forward")
    assert deflected() == (0.0, 0.0, 0.0)
    desk.now += 0.4
    assert deflected() == (0.0, 0.0, 0.0), "the stick is still held"
    assert desk.agents.done == [(ONE, Perform("Forward"))]
    desk.demonstrator.steer((0.0, 0.0, 0.0), 0.0)
    assert deflected() == (0.3, 0.0, 0.0)
    assert desk.agents.done[1:] == [(ONE, Perform())]
    assert deflected() == (0.3, 0.0, 0.0)
    desk.agents.become(ONE, "performing", "Forward")  # by another demonstrator
    assert deflected() == (0.0, 0.0, 0.0)
    assert "acts again: let go" in desk.demonstrator.said


@pytest.mark.parametrize("velocity", [(float("nan"), 0.0, 0.0), (0.1, float("inf"), 0.0)])
def test_what_is_no_velocity_stops_the_robot(desk, velocity):
    desk.press("up")
    desk.demonstrator.steer(velocity, 1.0)
    assert desk.driven == (0.0, 0.0, 0.0)


def test_a_robot_without_a_relay_cannot_be_driven_and_its_agent_is_left_alone(desk):
    desk.agents.link.node.listeners[0] = 0
    desk.agents.become(ONE, "performing", "Forward")
    said = desk.press("up")
    assert f"no velocity_relay listens on /{ONE}/cmd_vel_teleop" in said
    assert desk.agents.done == []
    count = desk.demonstrator.told
    desk.press("up", "up")
    assert desk.demonstrator.told == count, "it is said once"


def test_the_emergency_stop_counts_at_once_and_what_was_pressed_before_it_no_more(desk):
    desk.press("up")
    desk.demonstrator.press_behavior("Forward")
    desk.keyboard.press(" ")
    assert desk.demonstrator.switch.engaged
    assert desk.driven == (0.0, 0.0, 0.0)
    desk.demonstrator.work()
    assert desk.agents.done == []
    assert "nothing that acts is there" in desk.demonstrator.said
    desk.now += HOLD_S + 0.01
    assert desk.press("up") == "the emergency stop holds the robots"
    desk.press("G")
    assert not desk.demonstrator.switch.engaged


def test_an_arrow_that_is_pressed_twice_before_the_agent_answers_leaves_it_in_training(desk):
    desk.agents.become(ONE, "training", "Forward")
    desk.keyboard.press("up")
    desk.now += 0.6  # the first press has ended
    desk.keyboard.press("up")
    desk.demonstrator.work()
    assert desk.agents.done == [(ONE, Perform()), (ONE, TakeOver())]
