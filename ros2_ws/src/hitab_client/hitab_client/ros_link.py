"""A client node for talking to a swarm: spin until, subscribe, call."""

from __future__ import annotations

import contextlib
import os
import time
import uuid
from collections.abc import Callable, Iterator
from typing import Any, Self

import rclpy
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile

from hitab_client.dds_profile import choose_profile
from hitab_client.errors import SwarmError
from hitab_client.interruptions import not_interrupted
from hitab_core import Fix
from hitab_ros import NO_TYPE_DESCRIPTIONS, BusyTimeout, GuardedNode, suspensions_noticed

NODE_NAME = "hitab"
"""Name of the node of a program that talks to a swarm, always the same for security policies."""

CALL_SECONDS = 15.0
"""Timeout for the answer of an available service, s."""

REQUEST_REPEAT_SECONDS = 1.0
"""Time before a request is sent again, s; doubled each time."""

NOTICEABLE_SECONDS = 0.5
"""A wait that takes longer is announced."""


class RosLink:
    """A node, its executor and its clients; a context manager.

    Args:
        domain_id: ROS domain; None for that of the environment.
        announce: called with what a wait is for, once it takes noticeable time.
        name: of the node. Several programs may have the same one: they offer no services, and
            answers come to the client that asked, whatever its name.
    """

    def __init__(
        self,
        domain_id: int | None = None,
        announce: Callable[[str], None] | None = None,
        *,
        name: str = NODE_NAME,
    ) -> None:
        self._announce = announce
        self._announced: set[str] = set()
        choose_profile(os.environ)
        self._context = Context()
        try:
            rclpy.init(
                args=["--ros-args", "--disable-external-lib-logs"],
                context=self._context,
                domain_id=domain_id,
                signal_handler_options=rclpy.signals.SignalHandlerOptions.NO,
            )
        except RuntimeError as error:
            raise SwarmError(f"ROS does not start: {error}", Fix.DOCTOR()) from None
        self.node = GuardedNode(
            name, context=self._context, parameter_overrides=[NO_TYPE_DESCRIPTIONS]
        )
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        # What services tell clients apart by when a request is repeated.
        self._name = uuid.uuid4().hex
        self._requests = 0
        self._failure: BaseException | None = None
        self._suspended = 0.0  # s, if so long that others may have forgotten this node
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
            self._executor.remove_node(self.node)
            self.node.destroy_node()
            self._executor.shutdown()
            self._context.try_shutdown()

    def _note_suspension(self, seconds: float) -> None:
        self._suspended = seconds

    def spin(self, seconds: float = 0.1) -> None:
        """Handle pending events; wait at most this long for one, and defer Ctrl-C so long.

        Raises:
            SwarmError: if a long suspension of this process requires a new link.
        """
        if self._suspended:
            raise SwarmError(
                f"this program was suspended for {self._suspended:.0f} s, so that the swarm may "
                "have forgotten it: start it again"
            )
        # The executor's compiled code takes an interruption inside it for a failed conversion.
        with not_interrupted():
            self._executor.spin_once(timeout_sec=seconds)
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure

    def spin_until(
        self,
        done: Callable[[], Any],
        seconds: float,
        each: float = 0.05,
        waiting_for: Callable[[], str] | None = None,
    ) -> bool:
        """Spin until ``done()`` is true; return whether it became true in time.

        Args:
            done: the condition.
            seconds: how long to wait for it; longer on a busy machine, see `BusyTimeout`.
            each: seconds between two looks, if nothing happens.
            waiting_for: returns what to announce if the wait takes noticeable time.
        """
        began, patience = time.monotonic(), BusyTimeout(seconds)
        while not done():
            step = patience.step(each)
            if not step:
                return False
            if waiting_for is not None and time.monotonic() - began > NOTICEABLE_SECONDS:
                self._announce_once(f"waiting for {waiting_for()}")
                waiting_for = None
            self.spin(step)
        return True

    def _announce_once(self, text: str) -> None:
        if self._announce is not None and text not in self._announced:
            self._announced.add(text)
            self._announce(text)

    def subscribe(
        self,
        kind: Any,
        topic: str,
        take: Callable[[Any], None],
        qos: QoSProfile,
        *,
        temporary: bool = False,
    ) -> Any:
        """Subscribe; the next spin raises exceptions from ``take``."""

        def guarded(message: Any) -> None:
            # Otherwise the node's guard would only log it.
            try:
                take(message)
            except BaseException as error:
                self._failure = error

        return self.node.create_subscription(kind, topic, guarded, qos, temporary=temporary)

    def topics_of_type(self, kind: str) -> Iterator[str]:
        """Yield the discovered topics with this message type."""
        for topic, kinds in self.node.get_topic_names_and_types():
            if kind in kinds:
                yield topic

    def will_call(self, kind: Any, service: str) -> None:
        """Prepare to call a service, for discovery while others are called."""
        if service not in self._clients:
            self._clients[service] = self.node.create_client(kind, service)

    def call(
        self,
        kind: Any,
        service: str,
        request: Any,
        *,
        missing: Callable[[], SwarmError],
        discovery: float = 8.0,
        seconds: float = CALL_SECONDS,
    ) -> Any:
        """Call a service and return its answer, even a refusal.

        An answer may be lost, for example if the service has not discovered this client yet, so
        the request is repeated until there is an answer. Requests that change something are
        numbered, so that they are carried out only once.

        Args:
            kind: the type of the service.
            service: full name of the service.
            request: to send.
            missing: returns the error if the service is not there.
            discovery: seconds to wait for the service to appear.
            seconds: seconds to wait for its answer.

        Raises:
            SwarmError: if the service is not there or does not answer.
        """
        self.will_call(kind, service)
        client = self._clients[service]
        if not self.spin_until(
            client.service_is_ready, discovery, 0.01, lambda: f"{service} to appear"
        ):
            raise missing()
        if getattr(request, "request", None) == 0:
            self._requests += 1
            request.request, request.client = self._requests, self._name
        deadline = time.monotonic() + seconds
        patience = REQUEST_REPEAT_SECONDS
        sent: list[Any] = []

        def answered() -> Any:
            return next((future for future in sent if future.done()), None)

        try:
            while (left := deadline - time.monotonic()) > 0:
                sent.append(client.call_async(request))
                if self.spin_until(
                    answered, min(patience, left), 0.05, lambda: f"the answer of {service}"
                ):
                    return answered().result()
                patience *= 2
        finally:
            for future in sent:
                if not future.done():
                    client.remove_pending_request(future)
        late = f"{service} did not answer within {seconds:g} s"
        raise SwarmError(late, Fix.LOGS(node=service.split("/")[-2]))
