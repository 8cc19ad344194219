"""Signs of life of a swarm's machines, and what they show of the network between them."""

from __future__ import annotations

import math
import secrets
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from hitab_msgs.msg import MachineLink, MachineStatus
from rclpy.node import Node

from hitab_ros import Presence, names, qos, steady_timer
from hitab_ros.leases import machine_rank
from hitab_ros.messages.stamps import seconds_of, time_of
from hitab_ros.timing import HEARTBEAT_S

KEPT = 120
"""Number of latest signs that count for the loss."""

FILTERED = 8
"""Number of latest answers of which the fastest tells delay and offset, as in NTP."""

OFFSET_MAX_S = 1.0
"""Difference of clocks that is no fault, s; people compare logs by the second."""

MACHINES_MAX = 1000
"""Maximum number of machines, whatever is received."""

Fill = Callable[[MachineStatus], object]


class HeardMachine:
    """What one machine hears of another.

    Attributes:
        status: the last status of the other machine.
        loss: share of its latest messages that was lost, 0 to 1.
        delay: half of the shortest recent time to it and back, s; NaN until it hears this one.
        offset: its wall clock minus this one, s; NaN until it hears this one.
        processes: time of the last message of each process in its name, by the process's number.
    """

    def __init__(self) -> None:
        self.status = MachineStatus()
        self.loss = 0.0
        self.delay = self.offset = math.nan
        self.processes: dict[int, float] = {}
        self._heard = 0.0
        self._sequences: deque[int] = deque(maxlen=KEPT)
        self._answers: deque[tuple[float, float]] = deque(maxlen=FILTERED)

    def hear(self, status: MachineStatus, machine: str, sent: dict[int, float]) -> None:
        """Take in a status.

        Args:
            status: the status.
            machine: name of this machine.
            sent: wall-clock time at which this machine sent its latest messages, s, by sequence.
        """
        now = time.time()
        if status.process != self.status.process:
            self._sequences.clear()
        self.status, self._heard = status, now
        self.processes[status.process] = now
        self._sequences.append(status.sequence)
        span = self._sequences[-1] - self._sequences[0] + 1
        self.loss = max(0.0, 1.0 - len(self._sequences) / span) if span > 0 else 0.0
        for link in status.links:
            if link.machine == machine and (began := sent.get(link.sequence)) is not None:
                arrived, left = seconds_of(link.heard), seconds_of(status.stamp)
                there_and_back = (now - began) - (left - arrived)
                offset = ((arrived - began) + (left - now)) / 2.0
                self._answers.append((max(0.0, there_and_back), offset))
                fastest, self.offset = min(self._answers)
                self.delay = fastest / 2.0

    def link(self) -> MachineLink:
        """Return a message with what is heard."""
        return MachineLink(
            machine=self.status.machine,
            age=time.time() - self._heard,
            loss=self.loss,
            delay=self.delay,
            offset=self.offset,
            sequence=self.status.sequence,
            heard=time_of(self._heard),
        )


class MachineSigns:
    """Gives signs of life of a machine, and hears those of the others.

    Spin the node, and call `silent` periodically.

    Args:
        node: the node to use.
        prefix: namespace of the swarm.
        swarm: the swarm's identity; empty for any.
        machine: name of this machine; empty to only listen.
        fill: called with each own status before it is sent, to complete it.

    Attributes:
        heard: the other machines that were heard, by name.
    """

    def __init__(
        self,
        node: Node,
        prefix: str,
        swarm: str,
        machine: str = "",
        fill: Fill = lambda status: None,
    ) -> None:
        self.heard: dict[str, HeardMachine] = {}
        self._status = MachineStatus(
            machine=machine, swarm=swarm, process=secrets.randbits(63), sequence=0
        )
        self._fill = fill
        self._sent: dict[int, float] = {}
        self._presence = Presence()
        topic = names.of_swarm(names.MACHINES, prefix)
        node.create_subscription(MachineStatus, topic, self._hear, qos.SIGNS_OF_LIFE)
        self._publisher: Any = None
        if machine:
            self._publisher = node.create_publisher(MachineStatus, topic, qos.SIGNS_OF_LIFE)
            steady_timer(node, HEARTBEAT_S, self._give)

    def silent(self) -> dict[str, float]:
        """Return the silent machines with the time since their last sign, s."""
        return self._presence.silent()

    def statuses(self) -> dict[str, MachineStatus]:
        """Return the last status of each machine that was heard, by name."""
        return {name: heard.status for name, heard in self.heard.items()}

    def machine_of(self) -> dict[str, str]:
        """Return the machine that has each agent and commander."""
        claims = [
            (machine_rank(name, process), name, process.agents)
            for name, status in self.statuses().items()
            for process in status.processes
        ]
        claims.sort(key=lambda claim: claim[0], reverse=True)
        return {agent: machine for _, machine, agents in claims for agent in agents}

    def _hear(self, status: MachineStatus) -> None:
        own = self._status
        if own.swarm not in ("", status.swarm) or status.process == own.process:
            return
        if status.machine not in self.heard and len(self.heard) >= MACHINES_MAX:
            return
        self._presence.hear(status.machine)
        machine = self.heard.setdefault(status.machine, HeardMachine())
        machine.hear(status, own.machine, self._sent)

    def _give(self) -> None:
        status = self._status
        status.sequence += 1
        status.links = [machine.link() for machine in self.heard.values()]
        self._fill(status)
        now = time.time()
        status.stamp = time_of(now)
        self._sent[status.sequence] = now
        self._sent.pop(status.sequence - KEPT, None)
        self._publisher.publish(status)
