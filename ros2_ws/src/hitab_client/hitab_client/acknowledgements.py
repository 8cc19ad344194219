"""Acknowledgements of a behavior that one agent has sent to others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from hitab_msgs.msg import DistributionAck

from hitab_client.connecting.ros_link import RosLink
from hitab_ros import names, qos
from hitab_ros.timing import PROMPT_S

QUIET_SECONDS = 10.0
"""Maximum time between two acknowledgements, s; missing ones are then given up."""


@dataclass
class DistributionReport:
    """The receivers' answers to a distribution.

    Attributes:
        sequence: the distribution's number.
        digest: the behavior's digest, as the source computed it.
        accepted: receivers that verified the same digest.
        refused: receivers that refused, with their reasons.
        silent: receivers that did not answer.
        message: the source's own message.
    """

    sequence: int = 0
    digest: str = ""
    accepted: list[str] = field(default_factory=list)
    refused: dict[str, str] = field(default_factory=dict)
    silent: list[str] = field(default_factory=list)
    message: str = ""

    @property
    def missing(self) -> dict[str, str]:
        """Reasons why the other receivers do not have the behavior."""
        refusing = {n: f"refuses: {w.removeprefix(f'{n} ')}" for n, w in self.refused.items()}
        return refusing | dict.fromkeys(self.silent, "does not answer")


class Acknowledgements:
    """The acknowledgements of distributions.

    Args:
        link: the node to use.
        prefix: namespace of the swarm.
    """

    def __init__(self, link: RosLink, prefix: str = "") -> None:
        self._link = link
        self._prefix = prefix
        self._acks: dict[int, dict[str, DistributionAck]] = {}
        self._topic = names.of_swarm(names.DISTRIBUTION_ACK, prefix)
        link.subscribe(DistributionAck, self._topic, self._take, qos.ROLL_CALL)

    def _take(self, ack: DistributionAck) -> None:
        self._acks.setdefault(ack.sequence, {})[ack.agent] = ack

    async def await_hearing(self, alone: Iterable[str]) -> None:
        """Wait until acknowledgements can arrive from all hosts, and from agents outside of hosts.

        Args:
            alone: the agents outside of hosts.
        """
        hosts = names.of_swarm(names.STATUSES, self._prefix)
        unheard = {names.of_agent(agent, names.STATUS, self._prefix) for agent in alone}

        def heard() -> bool:
            publishing = self._processes(self._topic)
            for status in sorted(unheard):
                if self._processes(status) & publishing:
                    unheard.discard(status)
            return not unheard and self._processes(hosts) <= publishing

        await self._link.until(heard, PROMPT_S, 0.01)

    def _processes(self, topic: str) -> set[tuple[int, ...]]:
        """Return the processes that publish a topic, by DDS GUID prefix."""
        infos = self._link.node.get_publishers_info_by_topic(topic)
        return {tuple(info.endpoint_gid[:12]) for info in infos}

    async def gather(
        self,
        sequence: int,
        digest: str,
        receivers: Sequence[str],
        seconds: float,
        progress: Callable[[int, int], None] | None,
    ) -> DistributionReport:
        """Wait for all answers to a distribution, as long as the next one arrives in time."""
        acks = self._acks.setdefault(sequence, {})
        wanted = set(receivers)
        known = -1

        def one_more() -> bool:
            return len(acks) > known

        while True:
            if progress is not None:
                progress(len(wanted & acks.keys()), len(wanted))
            known = len(acks)
            if wanted <= acks.keys() or not await self._link.until(one_more, seconds):
                break
        report = DistributionReport(sequence, digest)
        for name in receivers:
            ack = acks.get(name)
            if ack is None:
                report.silent.append(name)
            elif ack.success and ack.digest == digest:
                report.accepted.append(name)
            else:
                report.refused[name] = ack.message or "its files differ from those that were sent"
        return report
