"""Hears the behavior files that agents distribute, and sends such files to agents.

A distribution carries a behavior with all that it is made of, word for word. So a program can keep
what an agent has learned, and bring it back, wherever the agent's library is.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial

from hitab_msgs.msg import BehaviorFile, Distribution
from hitab_msgs.srv import Distribute

from hitab_client.errors import SwarmError
from hitab_client.swarm_client import SwarmClient
from hitab_core import Fix
from hitab_core.library import bundle_digest
from hitab_ros import names, qos

NOBODY = "nobody"
"""Receiver of a distribution for this program alone."""

HEAR_SECONDS = 2.0
SEND_SECONDS = 2.0
TRIES = 5


class KeptCopies:
    """The distributions of a swarm, heard and sent.

    Args:
        swarm: the agents.
    """

    def __init__(self, swarm: SwarmClient) -> None:
        self._swarm = swarm
        self._link = swarm.link
        self._heard: dict[int, dict[str, str]] = {}
        topic = names.of_swarm(names.DISTRIBUTION, swarm.prefix)
        self._link.subscribe(Distribution, topic, self._take, qos.EVENTS)
        self._publisher = self._link.node.create_publisher(Distribution, topic, qos.EVENTS)

    def _take(self, sent: Distribution) -> None:
        self._heard[sent.sequence] = {file.name: file.text for file in sent.files}

    def present(self, agent: str, behavior: str) -> Mapping[str, str]:
        """Return a behavior of an agent and all that it is made of: the texts of the files.

        Raises:
            SwarmError: if the agent has no such trained behavior, or is not heard.
        """
        for _ in range(TRIES):
            # Nobody takes it in, so nothing changes.
            answer = self._swarm.ask(
                agent, Distribute, names.DISTRIBUTE, behavior=behavior, receivers=[NOBODY]
            )
            sequence = answer.sequence
            if self._link.spin_until(partial(self._heard.get, sequence), HEAR_SECONDS, 0.01):
                return self._heard[sequence]
        raise SwarmError(
            f"{agent} has sent its files {TRIES} times, and none arrived here", Fix.DOCTOR()
        )

    def send(self, agent: str, behavior: str, files: Mapping[str, str]) -> None:
        """Give behaviors to an agent, all or none, and wait until they are in its library.

        Args:
            agent: to give them to.
            behavior: the one that is meant.
            files: their texts by name, each after those that it uses.

        Raises:
            SwarmError: if the agent refuses them, or does not answer.
        """
        made = tuple(files.items())
        sequence = time.time_ns()
        message = Distribution(
            sequence=sequence,
            source=NOBODY,
            receivers=[agent],
            behavior=behavior,
            digest=bundle_digest(made),
            files=[BehaviorFile(name=name, text=text) for name, text in made],
        )
        self._swarm.acknowledgements.await_hearing([agent])
        self._link.spin_until(
            lambda: self._publisher.get_subscription_count() > 0, HEAR_SECONDS, 0.01
        )
        for _ in range(TRIES):
            # The agent may not have been discovered yet. To take the same in twice is harmless.
            self._publisher.publish(message)
            report = self._swarm.acknowledgements.gather(
                sequence, message.digest, [agent], SEND_SECONDS, None
            )
            if report.refused:
                raise SwarmError(f"{agent} refuses {behavior}: {report.refused[agent]}")
            if report.accepted:
                return
        raise SwarmError(
            f"{agent} has not confirmed that it received {behavior}; probably it has not changed",
            Fix.LOGS(node=agent),
        )
