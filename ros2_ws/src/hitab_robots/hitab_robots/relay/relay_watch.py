"""The watch on a robot's relay: whether it lives, and whether the robot may act."""

from __future__ import annotations

from hitab_msgs import msg

from hitab_agent import AgentNode
from hitab_robots.relay.process_state import REPLACED_AFTER_S
from hitab_robots.relay.relay_process import RELAY_HUNG_S, RelayProcess
from hitab_robots.settings import HEARTBEAT
from hitab_ros import Presence, StopState, names, qos, steady_timer, stop_report, why_stopped
from hitab_ros.timing import REPEAT_S, STOP_REPORT_PERIOD_S


class RelayWatch:
    """Sends the relay signs of life, and withholds the agent's actions while the relay is stopped.

    A relay that has ended or hangs is restarted. Until the new relay gives a sign of life, this
    class sends the base zero velocities, since the base may hold an older velocity.

    Attributes:
        why: why the robot may not act, and the way out; empty if it may.
        is_emergency: whether an emergency stop holds the robot.
    """

    def __init__(self, node: AgentNode, process: RelayProcess | None) -> None:
        """Begin to watch.

        Args:
            node: the agent's node.
            process: the relay's process; None if the relay is started elsewhere.
        """
        self.why = f"its {names.VELOCITY_RELAY} has not answered yet"
        self.is_emergency = False
        self._node = node
        self._process = process
        self._cause = ""
        self._is_replaced = False
        self._presence = Presence(RELAY_HUNG_S, STOP_REPORT_PERIOD_S)
        self._hear_relay(0.0 if process is None else REPLACED_AFTER_S)
        self._publisher = node.create_publisher(msg.StopState, HEARTBEAT, qos.STREAM)
        node.create_subscription(msg.StopState, names.STOP_STATE, self._hear, qos.STREAM)
        steady_timer(node, STOP_REPORT_PERIOD_S, self._look)

    def cause(self, why: str) -> None:
        """Stop the robot until it is re-armed; ``why`` its agent cannot act, empty if it can."""
        if why != self._cause:
            self._cause = why
            self._give_sign()

    def _hear_relay(self, due_in_s: float = 0.0) -> None:
        self._presence.hear(names.VELOCITY_RELAY, due_in_s)

    def _hear(self, relay: msg.StopState) -> None:
        self._hear_relay()
        self.is_emergency = bool(relay.emergencies)
        self._set_why(why_stopped(relay.why, relay.causes))

    def _look(self) -> None:
        self._give_sign()
        unheard_s = self._presence.age(names.VELOCITY_RELAY)
        if self._process is not None and (trouble := self._process.trouble(unheard_s)):
            self._node.guard.log(trouble)
            self._set_why(trouble)
            self._is_replaced = True
            if unheard_s >= REPEAT_S - REPLACED_AFTER_S:
                self._process.start()
                self._hear_relay(REPLACED_AFTER_S)
                unheard_s = -REPLACED_AFTER_S
        elif unheard_s > RELAY_HUNG_S:
            self._set_why(f"its {names.VELOCITY_RELAY} gives no sign of life")
        if self._process is not None and self._is_replaced and unheard_s < 0.0:
            self._process.stand_in()

    def _give_sign(self) -> None:
        stopped = StopState.STOPPED if self._node.stands() else StopState.STOPPING
        state = stopped if self.why else StopState.ARMED
        causes = [self._cause] if self._cause else []
        self._publisher.publish(stop_report(self._node, state, causes))

    def _set_why(self, why: str) -> None:
        if why != self.why:
            self.why = why
            self._node.stop_changed()
            self._give_sign()
