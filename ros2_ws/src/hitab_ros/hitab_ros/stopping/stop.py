"""Stop of one robot as a part of its node: reports and the re-arming service."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from hitab_msgs import msg, srv
from rclpy.node import Node

from hitab_ros import names, qos
from hitab_ros.messages.stamps import as_time
from hitab_ros.nodes.fault_texts import STOPPED, WAITS_TO_BE_ARMED
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.nodes.steady_timer import steady_timer
from hitab_ros.stopping.emergency_stop import EmergencySwitch, stopped_by
from hitab_ros.stopping.known_stops import KnownStops
from hitab_ros.stopping.stop_machine import JUST_STARTED, StopMachine, StopState
from hitab_ros.timing import STOP_REPORT_PERIOD_S


class Stop:
    """The stop machine of a robot on a node, driven by the emergency stop and by other causes.

    Attributes:
        EMERGENCY: name of the cause "emergency stop".
        machine: state machine of the robot's stop.
        switch: switch of the emergency stop.
    """

    EMERGENCY = "emergency stop"

    def __init__(
        self,
        node: GuardedNode,
        stands: Callable[[], bool],
        *,
        changed: Callable[[], None] = lambda: None,
        rearms: bool = False,
        known: KnownStops | None = None,
        keep: Callable[[KnownStops], None] = lambda known: None,
    ) -> None:
        """Create a stop in its stopped state.

        Args:
            node: node in the robot's namespace.
            stands: returns whether the robot stands still.
            changed: called after each change.
            rearms: whether the robot re-arms itself when no cause is left.
            known: emergency stops that this participant knew at its last exit.
            keep: called with the known emergency stops after each change.
        """
        self._node = node
        self._stands = stands
        self._tell_others = changed
        self._keep = keep
        self._rearms = rearms
        self._logged = ""
        self._publisher = node.create_publisher(msg.StopState, names.STOP_STATE, qos.STREAM)
        self.machine = StopMachine(rearms=rearms, changed=self._changed)
        self.switch = EmergencySwitch(node, self._emergency, hands_on=True, known=known)
        self._emergency(self.switch.known)
        node.create_service(srv.Arm, names.ARM, self._arm)
        steady_timer(node, STOP_REPORT_PERIOD_S, self._look)

    @property
    def why(self) -> str:
        """Reason why the robot may not act; empty if it may."""
        machine = self.machine
        return why_stopped(machine.why, machine.causes.values())

    def _emergency(self, known: KnownStops) -> None:
        if self.EMERGENCY in self.machine.causes and not known:
            self._log(f"the emergency stop is released by {[*known.released.values()][-1]}")
        self.machine.cause(self.EMERGENCY, stopped_by(known))
        self._keep(known)

    def _arm(self, request: srv.Arm.Request, response: srv.Arm.Response) -> srv.Arm.Response:
        response.message = self.machine.arm(request.stop)
        response.success = not response.message
        return response

    def _look(self) -> None:
        self.machine.look(stands=self._stands())
        self.publish()

    def _changed(self) -> None:
        why, before = self.machine.why, self._logged
        self._logged = why
        if why and why != before:
            self._log(f"{STOPPED}: {why}")
        elif before and not why:
            self._log("re-armed by itself" if self._rearms else "re-armed")
        self.publish()
        self._tell_others()

    def _log(self, text: str) -> None:
        self._node.get_logger().warning(text)

    def publish(self) -> None:
        """Publish a report."""
        machine = self.machine
        report = stop_report(
            self._node, machine.state, machine.causes.values(), machine.why, self.switch
        )
        report.stop = machine.stop
        self._publisher.publish(report)


def stop_report(
    node: Node,
    state: StopState,
    causes: Iterable[str],
    why: str = "",
    switch: EmergencySwitch | None = None,
) -> msg.StopState:
    """Return a report on whether a robot or world may act.

    Args:
        node: the reporting node.
        state: state of the robot or the world.
        causes: present reasons to stand still.
        why: reason of the stop.
        switch: switch that the node obeys; None if it obeys another node.
    """
    report = msg.StopState(
        stamp=as_time(time.time_ns()),
        node=node.get_fully_qualified_name(),
        name=names.own_name(node),
        state=state.value,
        causes=list(causes),
        why=why,
    )
    if switch is not None:
        report.emergencies = list(switch.known.stops)
    return report


def why_stopped(why: str, causes: Iterable[str]) -> str:
    """Return why a robot may not act; empty if it may.

    Args:
        why: reason of the stop.
        causes: present reasons to stand still.
    """
    if not why:
        return ""
    if reasons := "; ".join(causes):
        return f"{STOPPED}: {reasons}"
    return f"{WAITS_TO_BE_ARMED}: {why if why == JUST_STARTED else f'{why}; that is over'}"
