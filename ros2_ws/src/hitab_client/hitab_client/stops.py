"""Stops and releases whatever acts, learns what has come of it, and re-arms robots."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Sequence

from hitab_msgs.msg import StopState
from hitab_msgs.srv import Arm

from hitab_client.errors import SwarmError
from hitab_client.ros_link import RosLink
from hitab_core import natural, some
from hitab_ros import EmergencySwitch, names, qos, why_stopped
from hitab_ros.call import blocking

TYPE = "hitab_msgs/msg/StopState"

FRESH_S = 1.0
"""Time for which a report is valid, s. Reports come several times a second."""

REPEAT_S = 0.5
"""Period of an emergency stop's messages to robots that have not confirmed it, s."""

SETTLED_S = 0.7
"""All are known once no new one was found for so long, s."""


class Stops:
    """Stop reports of the robots and simulated worlds in one ROS domain.

    Args:
        link: the node to use.
        expected: names of robots that are known to be there, though nothing of them may answer.
        switch: of the emergency stop; None for a new one.

    Attributes:
        switch: the same.
        found_at: when a robot or world was last found, by the monotonic clock.
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
        self._reports: dict[str, tuple[float, StopState]] = {}  # when each came, by topic
        self._topics: set[str] = set()
        self.found_at = time.monotonic()
        self._meant: set[str] = set()  # identities of what was stopped or released
        self.look()

    @property
    def domain_id(self) -> int:
        """The ROS domain."""
        return int(self.link.node.context.get_domain_id())

    def look(self) -> None:
        """Look who is there; call it about twice a second."""
        for topic in set(self.link.topics_of_type(TYPE)) - self._topics:
            self._topics.add(topic)
            self.found_at = time.monotonic()
            if topic.endswith(f"/{names.STOP_STATE}"):  # the others are of agents to their relays
                self.link.subscribe(StopState, topic, self._taker(topic), qos.STREAM)

    def _taker(self, topic: str) -> Callable[[StopState], None]:
        def take(report: StopState) -> None:
            self._reports[topic] = time.monotonic(), report

        return take

    def _present(self) -> Iterator[tuple[str, StopState | None]]:
        """Yield the name of each robot and world, and its last report; None if it is too old."""
        of_robots = {topic.rpartition("/")[0].removeprefix("/") for topic in self._topics}
        for name in of_robots | set(self._expected):
            topic = f"/{name}/{names.STOP_STATE}"
            when, report = self._reports.get(topic, (0.0, None))
            if report is not None and time.monotonic() - when < FRESH_S:
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
        """Return the names of the robots and worlds that are there, sorted."""
        return sorted((name for name, _ in self._present()), key=natural)

    def unconfirmed(self, *, engaged: bool) -> dict[str, str]:
        """Return who has not confirmed to stand still, or to be released, and why not."""
        found = {}
        for name, report in self._present():
            if report is None:
                found[name] = "does not answer"
            elif bool(self._meant & {*report.emergencies}) is not engaged:
                found[name] = "has not heard it"
            elif engaged and report.state != StopState.STOPPED:
                found[name] = "still moves"
            elif not engaged and report.emergencies:
                found[name] = f"still stopped: {'; '.join(report.causes)}"
        return found

    def say(self, by: str, reason: str = "", *, engaged: bool) -> None:
        """Stop whatever acts, or release it; say it again to those who have not confirmed it.

        What holds a robot is released only if it was known when it was first said.

        Raises:
            SwarmError: if the stop was released meanwhile.
        """
        known = self.switch.known
        reported = {it for _, report in self._present() if report for it in report.emergencies}
        if engaged and (ended := self._meant & {*known.released}):
            raise SwarmError(f"released meanwhile by {known.released[ended.pop()]}")
        if self._meant:
            self.switch.tell()
        elif engaged or reported <= {*known.stops, *known.released}:
            self._meant = self.switch.set(engaged, by, reason)

    def label(self, name: str, ends: Sequence[Stops]) -> str:
        """Return a robot's name, with the ROS domain if it is in several of these."""
        several = sum(name in end.names() for end in ends) > 1
        return f"{name} in ROS domain {self.domain_id}" if several else name

    def waiting(self) -> dict[str, tuple[str, bool]]:
        """Return the robots that may not act, why, and whether an emergency stop holds them."""
        return {
            name: (why_stopped(report.why, report.causes), bool(report.emergencies))
            for name, report in self._present()
            if report is not None and report.why and report.stop  # a world is not re-armed
        }

    @blocking
    async def arm(self, robot: str, seconds: float) -> None:
        """Let a robot act again.

        Args:
            robot: its name, as `names` has it.
            seconds: how long to wait for its answer.

        Raises:
            SwarmError: if it may not, or does not answer.
        """
        topic = f"/{robot}/{names.STOP_STATE}"
        until = time.monotonic() + seconds
        while topic not in self._reports and time.monotonic() < until:
            self.look()
            await self.link.until(lambda: topic in self._reports, REPEAT_S)
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
        """Stop whatever acts, or release it, again and again until all have confirmed it.

        Args:
            ends: of all ROS domains that are meant.
            by: who wants it, for people.
            reason: for people.
            engaged: whether they have to stand still.
            seconds: how long at most.
            tell: called about twice a second with those who have not confirmed it, and how long
                it has been said, s.

        Returns:
            Those who have not confirmed it, and why not.

        Raises:
            SwarmError: if the stop was released meanwhile.
        """
        lacking: dict[str, str] = {}
        began = time.monotonic()
        while time.monotonic() < began + seconds:
            says = engaged or Stops.settled(ends)  # a release ends what is known when it is said
            for end in ends if says else ():
                end.say(by, reason, engaged=engaged)
            Stops.listen(ends, REPEAT_S)
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
        """Hear for so long who is there, and what they say."""
        for _ in range(2):  # to look is much work
            until = time.monotonic() + seconds / 2
            for end in ends:
                end.look()
            while time.monotonic() < until:
                for end in ends:
                    end.link.spin(0.02)

    @staticmethod
    def settled(ends: Sequence[Stops]) -> bool:
        """Whether no new one was found for a while."""
        return all(time.monotonic() - end.found_at > SETTLED_S for end in ends)
