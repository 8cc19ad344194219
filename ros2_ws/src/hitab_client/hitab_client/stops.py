"""Emergency stop of all robots and worlds, its confirmations, and re-arming."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Sequence

from hitab_msgs.msg import StopState
from hitab_msgs.srv import Arm

from hitab_client.connecting.ros_link import RosLink
from hitab_client.errors import SwarmError
from hitab_core import natural, some
from hitab_ros import EmergencySwitch, names, qos, why_stopped
from hitab_ros.call import blocking
from hitab_ros.timing import CONNECT_S, HEARTBEAT_S, SILENT_AFTER_S

TYPE = "hitab_msgs/msg/StopState"


class Stops:
    """Stop reports of the robots and simulated worlds in one ROS domain.

    Args:
        link: the node to use.
        expected: names of robots that are known to exist, even if they do not answer.
        switch: switch of the emergency stop; None for a new one.

    Attributes:
        switch: switch of the emergency stop.
        found_at: time at which a robot or world was last discovered, by the monotonic clock.
    """

    def __init__(
        self,
        link: RosLink,
        expected: Collection[str] = (),
        switch: EmergencySwitch | None = None,
    ) -> None:
        self.link = link
        self._expected = expected
        self.switch = switch or EmergencySwitch(link.node)
        self._reports: dict[str, tuple[float, StopState]] = {}  # with times of receipt, by topic
        self._topics: set[str] = set()
        self.found_at = time.monotonic()
        self._requested: set[str] = set()  # identities of the requested stops or releases
        self.look()

    @property
    def domain_id(self) -> int:
        """The ROS domain."""
        return int(self.link.node.context.get_domain_id())

    def look(self) -> None:
        """Discover robots and worlds; call this about twice a second."""
        for topic in set(self.link.topics_of_type(TYPE)) - self._topics:
            self._topics.add(topic)
            self.found_at = time.monotonic()
            if topic.endswith(f"/{names.STOP_STATE}"):  # others go to relays
                self.link.subscribe(StopState, topic, self._taker(topic), qos.STREAM)

    def _taker(self, topic: str) -> Callable[[StopState], None]:
        def take(report: StopState) -> None:
            self._reports[topic] = time.monotonic(), report

        return take

    def _present(self) -> Iterator[tuple[str, StopState | None]]:
        """Yield the names of robots and worlds with their last reports, None if too old."""
        of_robots = {topic.rpartition("/")[0].removeprefix("/") for topic in self._topics}
        for name in of_robots | set(self._expected):
            topic = f"/{name}/{names.STOP_STATE}"
            when, report = self._reports.get(topic, (0.0, None))
            if report is not None and time.monotonic() - when < SILENT_AFTER_S:
                yield name, report
            elif name in self._expected or self._is_there(name):
                yield name, None

    def _is_there(self, name: str) -> bool:
        """Whether a robot's agent or relay, or a world, is still in the ROS graph."""
        return any(
            self.link.node.count_publishers(topic)
            for topic in self._topics
            if topic.rpartition("/")[0] == f"/{name}"
        )

    def names(self) -> list[str]:
        """Return the names of the robots and worlds, sorted."""
        return sorted((name for name, _ in self._present()), key=natural)

    def unconfirmed(self, *, engaged: bool) -> dict[str, str]:
        """Return why robots and worlds have not confirmed the stop or release, by name."""
        found = {}
        for name, report in self._present():
            if report is None:
                found[name] = "does not answer"
            elif bool(self._requested & {*report.emergencies}) is not engaged:
                found[name] = "has not heard it"
            elif engaged and report.state != StopState.STOPPED:
                found[name] = "still moves"
            elif not engaged and report.emergencies:
                found[name] = f"still stopped: {'; '.join(report.causes)}"
        return found

    def say(self, by: str, reason: str = "", *, engaged: bool) -> None:
        """Publish a stop or a release, again for robots and worlds that have not confirmed it.

        A release ends only the stops that were known when it was first published.

        Raises:
            SwarmError: if the stop was released meanwhile.
        """
        known = self.switch.known
        reported = {it for _, report in self._present() if report for it in report.emergencies}
        if engaged and (ended := self._requested & {*known.released}):
            raise SwarmError(f"released meanwhile by {known.released[ended.pop()]}")
        if self._requested:
            self.switch.tell()
        elif engaged or reported <= {*known.stops, *known.released}:
            self._requested = self.switch.set(engaged, by, reason)

    def label(self, name: str, ends: Sequence[Stops]) -> str:
        """Return a robot's name, with the ROS domain if it is in several of these."""
        several = sum(name in end.names() for end in ends) > 1
        return f"{name} in ROS domain {self.domain_id}" if several else name

    def waiting(self) -> dict[str, tuple[str, bool]]:
        """Return why robots may not act, and whether an emergency stop holds them, by name."""
        return {
            name: (why_stopped(report.why, report.causes), bool(report.emergencies))
            for name, report in self._present()
            if report is not None and report.why and report.stop  # a world is not re-armed
        }

    @blocking
    async def arm(self, robot: str, seconds: float) -> None:
        """Let a robot act again.

        Args:
            robot: name of the robot, as in `names`.
            seconds: timeout for the robot's answer.

        Raises:
            SwarmError: if the robot refuses or does not answer.
        """
        topic = f"/{robot}/{names.STOP_STATE}"
        until = time.monotonic() + seconds
        while topic not in self._reports and time.monotonic() < until:
            self.look()
            await self.link.until(lambda: topic in self._reports, HEARTBEAT_S)
        if topic not in self._reports:
            known = some(self.names()) if self.names() else "none is there"
            raise SwarmError(f"no robot {robot} says whether it may act; robots: {known}")
        request = Arm.Request(stop=self._reports[topic][1].stop)
        service = f"/{robot}/{names.ARM}"
        missing = SwarmError(f"{robot} cannot be re-armed: no node offers {service}")
        where = f"{robot} may not act again"
        await self.link.call.coroutine(Arm, service, request, missing=lambda: missing, where=where)

    @staticmethod
    def switch_all(
        ends: Sequence[Stops],
        by: str,
        reason: str = "",
        *,
        engaged: bool,
        seconds: float,
        tell: Callable[[dict[str, str], float], None] = lambda who, after: None,
    ) -> dict[str, str]:
        """Stop or release all robots and worlds; repeat until all have confirmed.

        Args:
            ends: stops of the chosen ROS domains.
            by: name of the person or program, for people.
            reason: reason, for people.
            engaged: whether to stop, not to release.
            seconds: timeout.
            tell: called about twice a second with the unconfirmed names and reasons, and the time
                since the first message, s.

        Returns:
            The reasons why robots and worlds have not confirmed, by name.

        Raises:
            SwarmError: if the stop was released meanwhile.
        """
        lacking: dict[str, str] = {}
        began = time.monotonic()
        while time.monotonic() < began + seconds:
            says = engaged or Stops.settled(ends)  # a release ends only known stops
            for end in ends if says else ():
                end.say(by, reason, engaged=engaged)
            Stops.listen(ends, HEARTBEAT_S)
            lacking = {
                end.label(name, ends): why
                for end in ends
                for name, why in end.unconfirmed(engaged=engaged).items()
            }
            found = any(end.names() for end in ends)
            if found and not lacking and Stops.settled(ends):
                break
            if says and (lacking or not found):
                tell(lacking, time.monotonic() - began)
        return lacking

    @staticmethod
    def listen(ends: Sequence[Stops], seconds: float) -> None:
        """Discover robots and worlds, and receive their reports, for some seconds."""
        for _ in range(2):  # discovery is expensive
            until = time.monotonic() + seconds / 2
            for end in ends:
                end.look()
            while time.monotonic() < until:
                for end in ends:
                    end.link.spin(0.02)

    @staticmethod
    def settled(ends: Sequence[Stops]) -> bool:
        """Whether no new robot or world was found for a while."""
        return all(time.monotonic() - end.found_at > CONNECT_S for end in ends)
