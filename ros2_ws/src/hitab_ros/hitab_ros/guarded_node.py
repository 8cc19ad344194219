"""The node that all nodes of the project are: its callbacks, whoever makes them, are guarded."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from hitab_ros.answering import what_went_wrong
from hitab_ros.guard import Guard


class GuardedNode(Node):
    """A node in which nothing that a callback raises leaves the callback.

    Subscriptions, timers, services, clients and guard conditions that are made on it are guarded,
    also those of a robot's link that somebody else has written. It has neither the topics nor the
    services that nobody here uses, unless asked for.

    Attributes:
        guard: runs the callbacks; its faults belong into the node's status.
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
            self.guard.log(f"faults cannot be shown: {what_went_wrong(error)}", "faults")

    def faults_changed(self) -> None:
        """Do what has to be done when a fault has appeared or gone, such as publish a status."""

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        *args: Any,
        checked: bool = True,
        **options: Any,
    ) -> Any:
        """Subscribe; see `rclpy.node.Node`. With ``checked`` bad messages are left out."""
        guarded = self.guard.wrap_topic(f"topic {topic}", callback, checked=checked)
        return super().create_subscription(msg_type, topic, guarded, *args, **options)

    def create_timer(
        self, timer_period_sec: float, callback: Callable[..., Any], *args: Any, **options: Any
    ) -> Any:
        """Make a timer; see `rclpy.node.Node`."""
        guarded = self.guard.wrap(f"timer {name_of(callback)}", callback)
        return super().create_timer(timer_period_sec, guarded, *args, **options)

    def create_guard_condition(
        self, callback: Callable[..., Any], *args: Any, **options: Any
    ) -> Any:
        """Make a guard condition; see `rclpy.node.Node`."""
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
        """Offer a service; see `rclpy.node.Node`."""
        guarded = self.guard.wrap_service(f"service {srv_name}", callback)
        return super().create_service(srv_type, srv_name, guarded, *args, **options)

    def create_client(self, srv_type: Any, srv_name: str, *args: Any, **options: Any) -> Any:
        """Make a client, whose answers are guarded as well; see `rclpy.node.Node`."""
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
    """Return what a callback is called, for people."""
    while isinstance(callback, functools.partial):
        callback = callback.func
    return getattr(callback, "__qualname__", type(callback).__name__)
