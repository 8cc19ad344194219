"""The joystick of a demonstrator: its messages on a topic become commands."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from sensor_msgs.msg import Joy

from hitab_client import RosLink
from hitab_client.demonstrating import Demonstrator, Pressed
from hitab_core import BoundedNumber, Term, quantity, with_numbers
from hitab_gamepad.joystick_mapping import Mapping
from hitab_gamepad.stick import Stick
from hitab_ros import qos, steady_timer
from hitab_ros.messages.stamps import seconds_of
from hitab_ros.timing import FOUND_S, UPDATE_S


@dataclass(frozen=True)
class _Held:
    """A button that a person holds while choosing its behavior's numbers with the sticks."""

    button: str
    behavior: str
    wanted: list[BoundedNumber]
    first: Pressed


class JoystickInput:
    """Passes a person's actions with a joystick on to a demonstrator.

    Args:
        link: the node to use.
        demonstrator: the demonstrator, which obeys the joystick.
        mapping: meaning of buttons and axes.
        topic: a topic of type `sensor_msgs/Joy`.
    """

    def __init__(
        self, link: RosLink, demonstrator: Demonstrator, mapping: Mapping, topic: str
    ) -> None:
        self._node = link.node
        self._demonstrator = demonstrator
        self._mapping = mapping
        self._stick = Stick(mapping)
        self._began = time.monotonic()
        self._was_there = False
        self._trouble = ""
        self._topic = topic
        self._held: _Held | None = None
        # The guard must not check and drop messages: one with NaN has to stop the robot.
        self._node.create_subscription(Joy, topic, self._take, qos.STREAM, checked=False)
        steady_timer(self._node, UPDATE_S, self._look)

    def _take(self, message: Joy) -> None:
        now = time.monotonic()
        was_lost = self._stick.is_lost(now)
        taken = self._stick.take(
            message.axes, message.buttons, seconds_of(message.header.stamp), time.time(), now
        )
        demonstrator = self._demonstrator
        if taken.trouble:
            self._report_trouble(taken.trouble)
        elif was_lost or self._trouble:
            self._was_there, self._trouble = True, ""
            hold = self._mapping.hold
            demonstrator.tell(f"the joystick is connected; nothing counts unless {hold} is held")
        if taken.trouble:
            demonstrator.let_go()
        elif self._held is None:
            demonstrator.steer(taken.velocity, self._mapping.timeout)
        for button in taken.pressed:
            self._press(button)
        if self._held is not None and self._held.button not in taken.down:
            held, self._held = self._held, None
            if self._mapping.hold in taken.down:
                self._command(held, message.axes)

    def _press(self, button: str) -> None:
        demonstrator = self._demonstrator
        if button in self._mapping.actions:
            demonstrator.press(self._mapping.actions[button])
            return
        behavior = self._mapping.behaviors.get(button, "")
        if isinstance(behavior, int):
            words = demonstrator.words
            named = words.number(behavior)
            if not named:
                demonstrator.tell(
                    f"{button} stands for behavior {behavior}, but {demonstrator.agent} has "
                    f"{quantity(len(words.behaviors), 'behavior')}",
                    failed=True,
                )
                return
            behavior = named
        if not behavior:
            return
        wanted = demonstrator.words.open_numbers(Term.parse(behavior))
        if wanted and all(number.name in self._mapping.numbers for number in wanted):
            demonstrator.let_go()
            self._held = _Held(button, behavior, wanted, demonstrator.pressed(behavior))
            names = ", ".join(number.name for number in wanted)
            demonstrator.tell(f"{behavior}: its {names} counts when you let {button} go")
        else:
            demonstrator.press_behavior(behavior)

    def _command(self, held: _Held, axes: Sequence[float]) -> None:
        """Command the held button's behavior, with the numbers that the sticks give now."""
        values = [self._mapping.numbers[n.name].read(n, axes) for n in held.wanted]
        if None in values:
            name = held.wanted[values.index(None)].name
            self._demonstrator.tell(
                f"{held.behavior} is not commanded: the stick gave no {name}; hold {held.button}, "
                f"push the stick, and let {held.button} go",
                failed=True,
            )
            return
        given = [round(value, 3) for value in values if value is not None]
        term = with_numbers(Term.parse(held.behavior), given, held.wanted)
        self._demonstrator.press_behavior(str(term), held.first)

    def _look(self) -> None:
        """Stop driving by hand when the joystick is lost."""
        now = time.monotonic()
        if not self._stick.is_lost(now):
            return
        if self._was_there:
            self._was_there, self._held = False, None
            self._demonstrator.let_go()
            self._report_trouble("the joystick is silent: driving by hand has stopped")
        elif not self._trouble and now > self._began + FOUND_S:
            number = self._node.context.get_domain_id()
            topic = self._node.resolve_topic_name(self._topic)
            self._report_trouble(
                f"waiting for a joystick: nothing comes on {topic} in ROS domain {number}; start "
                f"a joystick's node there, such as joy_node (ROS_DOMAIN_ID={number} "
                "ros2 run joy joy_node)"
            )

    def _report_trouble(self, why: str) -> None:
        if why != self._trouble:
            self._trouble = why
            self._demonstrator.tell(why, failed=True)
