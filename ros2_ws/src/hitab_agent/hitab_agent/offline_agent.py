"""An agent without world, robot or network, which is given again what a recorded one took in.

It is the node that every agent has, with its subscriptions and services. They are called directly,
since nobody is there.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import rclpy
from hitab_msgs import msg
from rclpy.context import Context
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from hitab_agent.agent_node import AgentNode
from hitab_core import BehaviorLibrary, Domain, HitabError, LibraryError, action_behaviors
from hitab_ros import names, session_topics

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


class _Node(AgentNode):
    """The node of an agent that has neither a world nor a robot."""

    def load_domain(self, name: str) -> Domain:
        """Return the domain without its robot: percepts come as from a world."""
        domain = super().load_domain(name)
        acts = sorted(behavior.name for behavior in action_behaviors(domain))
        if acts:
            raise HitabError(
                f'domain "{name}" has behaviors that are ROS actions ({", ".join(acts)}). A '
                "recording lacks what became of them, so nothing can be trained from it; save the "
                "training on the robot"
            )
        return replace(domain, link="")


class OfflineAgent:
    """An agent that is shown and asked what a recorded one was; a context manager."""

    def __init__(
        self, name: str, domain: str, library: Path, state: Path, known: msg.Distribution
    ) -> None:
        """Create the agent with what it knew.

        Args:
            name: of the agent; its random numbers depend on it.
            domain: name of an installed domain.
            library: a folder for its library, new or empty.
            state: a folder for the training under way, new or empty.
            known: the files of what it knew.

        Raises:
            HitabError: if it cannot be created, or these files make something else here.
        """
        self._context = Context()
        with _nobody_there():
            rclpy.init(context=self._context, args=["--ros-args", "--disable-external-lib-logs"])
        try:
            settings = {"domain": domain, "library": str(library), "state_dir": str(state)}
            self._node = _Node(
                context=self._context,
                namespace=f"/{name}",
                parameter_overrides=[Parameter(key, value=v) for key, v in settings.items()],
            )
            there = BehaviorLibrary(library, self._node.agent.domain)
            there.install({file.name: file.text for file in known.files})
            self._node.agent.reload()
            found = self._node.agent.edition.digest
            if found != known.digest:
                raise LibraryError(
                    f"the behaviors that {name} had when the recording began read differently "
                    f"here (digest {found[:12]}…, not {known.digest[:12]}…); use the version of "
                    f'HiTAB and of domain "{domain}" that recorded it'
                )
            self._node.join()
        except BaseException:
            self.close()
            raise
        self._topics = {s.topic_name.rpartition("/")[2]: s for s in self._node.subscriptions}
        self._services = {s.srv_name.rpartition("/")[2]: s for s in self._node.services}

    def __enter__(self) -> OfflineAgent:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """End the node."""
        node = getattr(self, "_node", None)
        if node is not None:
            node.agent.journal.close()
            node.destroy_node()
        self._context.try_shutdown()

    @property
    def agent(self) -> Any:
        """The agent in the node."""
        return self._node.agent

    def perceive(self, percept: msg.Percept) -> None:
        """Take in a percept and act on it, as if a world had sent it."""
        self._topics[names.PERCEPT].callback(serialize_message(percept))

    def command(self, command: msg.Command) -> None:
        """Obey a command, or refuse it."""
        self._topics[names.COMMAND].callback(serialize_message(command))

    def ask(self, service: str, request: Any) -> Any:
        """Return the answer to a request."""
        if service == session_topics.SEARCHED:
            # The node looks for them in slices between its cycles; they get the same numbers.
            if self.agent.session is not None:
                self.agent.session.asked.find()
            return None
        kind = session_topics.SERVICES[service]
        return self._services[service].callback(request, kind.Response())

    def status(self) -> msg.AgentStatus:
        """Return the status that it would publish now."""
        self._node.status.publish()
        return self._node.status.message


@contextmanager
def _nobody_there() -> Iterator[None]:
    """Have nodes of contexts that are created meanwhile find nobody, and be found by nobody."""
    before = os.environ.get(RANGE)
    os.environ[RANGE] = "OFF"
    try:
        yield
    finally:
        if before is None:
            del os.environ[RANGE]
        else:
            os.environ[RANGE] = before
