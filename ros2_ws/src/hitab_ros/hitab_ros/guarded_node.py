"""The base class of all nodes of the project, with guarded callbacks."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from hitab_ros.answering import what_went_wrong
from hitab_ros.guard import Guard


class GuardedNode(Node):
    """A node whose callbacks cannot raise into the executor.

    Subscriptions, timers, services, clients and guard conditions created on it are guarded,
    including those of a user's robot link. It omits unused standard topics and services by
    default.

    Attributes:
        guard: runs the callbacks; its faults belong in the node's status.
    """

    def __init__(self, node_name: str, **options: Any) -> None:
        self.guard = Guard(lambda text: self.get_logger().warning(text))
        self.guard.faults.changed = self._tell_of_faults
        options = {"enable_rosout": False, "start_parameter_services": False, **options}
        super().__init__(node_name, **options)

    def _tell_of_faults(self) -> None:
        try:
            self.faults_changed()
        except Exception as error:  # the guard calls this while it handles another error
            self.guard.log(f"faults cannot be published: {what_went_wrong(error)}", "faults")

    def faults_changed(self) -> None:
        """React to a change of the faults, for example by publishing a status."""

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        *args: Any,
        checked: bool = True,
        **options: Any,
    ) -> Any:
        """Subscribe; see `rclpy.node.Node`. With ``checked``, invalid messages are dropped."""
        guarded = self.guard.wrap_topic(f"topic {topic}", callback, checked=checked)
        return super().create_subscription(msg_type, topic, guarded, *args, **options)

    def create_timer(
        self, timer_period_sec: float, callback: Callable[..., Any], *args: Any, **options: Any
    ) -> Any:
        """Create a timer; see `rclpy.node.Node`."""
        guarded = self.guard.wrap(f"timer {name_of(callback)}", callback)
        return super().create_timer(timer_period_sec, guarded, *args, **options)

    def create_guard_condition(
        self, callback: Callable[..., Any], *args: Any, **options: Any
    ) -> Any:
        """Create a guard condition; see `rclpy.node.Node`."""
        guarded = self.guard.wrap(f"condition {name_of(callback)}", callback)
        return super().create_guard_condition(guarded, *args, **options)

    def create_service(
        self,
        srv_type: Any,
        srv_name: str,
        callback: Callable[..., Any],
        *args: Any,
        **options: Any,
    ) -> Any:
        """Create a service; see `rclpy.node.Node`."""
        guarded = self.guard.wrap_service(f"service {srv_name}", callback)
        return super().create_service(srv_type, srv_name, guarded, *args, **options)

    def create_client(self, srv_type: Any, srv_name: str, *args: Any, **options: Any) -> Any:
        """Create a client with guarded answers; see `rclpy.node.Node`."""
        client = super().create_client(srv_type, srv_name, *args, **options)
        call_async = client.call_async

        @functools.wraps(call_async)
        def call(request: Any) -> Any:
            future = call_async(request)
            add = future.add_done_callback
            future.add_done_callback = lambda done: add(  # type: ignore[method-assign]
                self.guard.wrap(f"answer of {srv_name}", done)
            )
            return future

        client.call_async = call  # type: ignore[method-assign]
        return client


def name_of(callback: Callable[..., Any]) -> str:
    """Return a callback's name, for people."""
    while isinstance(callback, functools.partial):
        callback = callback.func
    return getattr(callback, "__qualname__", type(callback).__name__)
