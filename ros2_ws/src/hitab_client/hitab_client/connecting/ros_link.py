"""Client node of a program that talks to a swarm."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from typing import Any, Self

import rclpy
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile

from hitab_client.connecting.dds_profile import choose_profile
from hitab_client.errors import SwarmError
from hitab_client.terminal.interruptions import not_interrupted
from hitab_core import Fix
from hitab_ros import (
    NO_TYPE_DESCRIPTIONS,
    GuardedNode,
    stop_receiving,
    suspensions_noticed,
    udp_sockets,
)
from hitab_ros.call import Caller

NODE_NAME = "hitab"
"""Name of the client node, always the same for security policies."""


class RosLink(Caller):
    """A node, its executor and its clients; a context manager.

    Args:
        domain_id: ROS domain; None for the environment's domain.
        announce: called with the reason of a wait, once the wait is noticeable.
        name: name of the node. Several programs may have the same name: they offer no services,
            and answers reach the client that sent the request, whatever its name.
    """

    def __init__(
        self,
        domain_id: int | None = None,
        announce: Callable[[str], None] | None = None,
        *,
        name: str = NODE_NAME,
    ) -> None:
        choose_profile(os.environ)
        self._context = Context()
        before = udp_sockets()
        try:
            rclpy.init(
                args=["--ros-args", "--disable-external-lib-logs", "--enclave", f"/{name}"],
                context=self._context,
                domain_id=domain_id,
                signal_handler_options=rclpy.signals.SignalHandlerOptions.NO,
            )
        except RuntimeError as error:
            raise SwarmError(f"ROS does not start: {error}", Fix.DOCTOR()) from None
        options: dict[str, Any] = {
            "context": self._context,
            "parameter_overrides": [NO_TYPE_DESCRIPTIONS],
        }
        super().__init__(GuardedNode(name, **options), announce)
        self._sockets = udp_sockets() - before
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._failure: BaseException | None = None
        self._ended = ""
        self._watch = contextlib.ExitStack()
        self._watch.enter_context(suspensions_noticed(self._note_suspension))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the ROS graph."""
        self._watch.close()
        if self._context.ok():
            stop_receiving(self._sockets)
            self._executor.remove_node(self.node)
            self.node.destroy_node()
            self._executor.shutdown()
            self._context.try_shutdown()

    def _note_suspension(self, seconds: float) -> None:
        self.end(
            f"this program was suspended for {seconds:.0f} s, so that the swarm may have "
            "forgotten it: start it again"
        )

    def end(self, why: str) -> None:
        """Make every `spin` raise from now on, in any thread."""
        self._ended = why

    def spin(self, seconds: float = 0.1) -> None:
        """Handle pending events; wait at most this long for one, and defer Ctrl-C meanwhile.

        Raises:
            SwarmError: if the link has ended, such as by a long suspension of this process.
        """
        if self._ended:
            raise SwarmError(self._ended)
        # The executor's compiled code mistakes an interruption for a failed conversion.
        with not_interrupted():
            self._executor.spin_once(timeout_sec=seconds)
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure

    def subscribe(
        self,
        kind: Any,
        topic: str,
        take: Callable[[Any], None],
        qos: QoSProfile,
        **options: Any,
    ) -> Any:
        """Subscribe; the next spin raises exceptions from ``take``.

        Args:
            kind: type of the messages.
            topic: name of the topic.
            take: called with each message.
            qos: quality of service.
            options: see `GuardedNode.create_subscription`.
        """

        def guarded(message: Any) -> None:
            # Otherwise the node's guard would only log it.
            try:
                take(message)
            except BaseException as error:
                self._failure = error

        return self.node.create_subscription(kind, topic, guarded, qos, **options)

    def topics_of_type(self, kind: str) -> Iterator[str]:
        """Yield the discovered topics with this message type."""
        for topic, kinds in self.node.get_topic_names_and_types():
            if kind in kinds:
                yield topic
