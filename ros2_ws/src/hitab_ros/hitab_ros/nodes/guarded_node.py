"""The base class of all nodes of the project, with guarded callbacks."""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.parameter import Parameter

from hitab_core import HitabError
from hitab_core.library.yaml_places import kind_of
from hitab_ros.answering import what_went_wrong
from hitab_ros.nodes.guard import Guard

WHOLE = (Parameter.Type.INTEGER, Parameter.Type.INTEGER_ARRAY)

NO_TYPE_DESCRIPTIONS = Parameter("start_type_description_service", value=False)
"""Options that omit an unused service of every node."""


class GuardedNode(Node):
    """A node whose callbacks cannot raise into the executor.

    Subscriptions, timers, services, clients and guard conditions created on it are guarded,
    including those of a user's robot link. It omits unused standard topics and services by
    default.

    Publishers and subscriptions that are destroyed before the node must be created with
    ``temporary=True``. They do not warn of peers with an incompatible QoS: rclpy's executors fail,
    or end the process, if such an event waits in their queue when its publisher or subscription is
    destroyed (https://github.com/ros2/rclpy/issues/1644).

    Attributes:
        guard: runs the callbacks; its faults belong in the node's status.
    """

    _has_left = False

    def __init__(
        self, node_name: str, *, publish_parameter_events: bool = True, **options: Any
    ) -> None:
        """Create the node.

        Args:
            node_name: name of the node.
            publish_parameter_events: whether the node publishes on ``/parameter_events``; needless
                for a node without parameter services, to which it is one more endpoint.
            options: see `rclpy.node.Node`.
        """
        self._publishes_parameter_events = publish_parameter_events
        self.guard = Guard(lambda text: self.get_logger().warning(text))
        self.guard.faults.changed = self._tell_of_faults
        options = {"enable_rosout": False, "start_parameter_services": False, **options}
        super().__init__(node_name, **options)

    def farewell(self) -> None:
        """Do the last things to which others have to respond, such as stopping a robot."""

    def leave(self) -> None:
        """Do the `farewell`, unless it was done; before the process stops receiving."""
        if not self._has_left:
            self._has_left = True
            self.farewell()

    def destroy_node(self) -> None:
        """Leave, then destroy the node."""
        self.leave()
        super().destroy_node()

    def _tell_of_faults(self) -> None:
        try:
            self.faults_changed()
        except Exception as error:  # the guard calls this while it handles another error
            self.guard.log(f"faults cannot be published: {what_went_wrong(error)}", "faults")

    def faults_changed(self) -> None:
        """React to a change of the faults, for example by publishing a status."""

    def declare_parameter(
        self,
        name: str,
        value: Any = None,
        descriptor: ParameterDescriptor | None = None,
        ignore_override: bool = False,
    ) -> Any:
        """Declare a parameter; see `rclpy.node.Node`. Floats accept whole numbers.

        Raises:
            HitabError: if the given value does not have the declared type.
        """
        given = None if ignore_override else self._parameter_overrides.get(name)
        default = value[0] if isinstance(value, list | tuple) and value else value
        if given is not None and isinstance(default, float) and given.type_ in WHOLE:
            is_one = given.type_ is Parameter.Type.INTEGER
            floats = float(given.value) if is_one else list(map(float, given.value))
            given = self._parameter_overrides[name] = Parameter(name, value=floats)
        is_new = value is not None and name not in self._parameters
        if is_new and not self._publishes_parameter_events:
            # Nobody listens to the event, for which rclpy makes many messages.
            is_type = isinstance(value, Parameter.Type)
            descriptor = ParameterDescriptor() if descriptor is None else descriptor
            kind = value if is_type else Parameter.Type.from_parameter_value(value)
            descriptor.type = kind.value
            if given is None or self._apply_descriptor(given, descriptor, False).successful:
                declared = given or Parameter(name, value=None if is_type else value)
                self._parameters[name], self._descriptors[name] = declared, descriptor
                return declared
        try:
            return super().declare_parameter(name, value, descriptor, ignore_override)
        except InvalidParameterTypeException as error:
            is_now = kind_of(self._parameter_overrides[name].value)
            raise HitabError(
                f'the parameter "{name}" is {is_now}; it must be such as {value}'
            ) from error

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        *args: Any,
        checked: bool = True,
        temporary: bool = False,
        raw: bool = False,
        read: Callable[[bytes], Any] | None = None,
        **options: Any,
    ) -> Any:
        """Subscribe; see `rclpy.node.Node`, and `Guard.wrap_topic` for ``checked`` and ``read``.

        Messages of more than `hitab_ros.messages.checks.BYTES_MAX` are dropped before
        deserialization, unless the callback takes ``raw`` messages.
        """
        kind = None if raw else msg_type
        key = f"topic {topic}"
        guarded = self.guard.wrap_topic(key, kind, callback, checked=checked, read=read)
        if temporary:
            events = SubscriptionEventCallbacks(use_default_callbacks=False)
            options = {"event_callbacks": events, **options}
        return super().create_subscription(msg_type, topic, guarded, *args, raw=True, **options)

    def create_publisher(
        self, msg_type: Any, topic: str, *args: Any, temporary: bool = False, **options: Any
    ) -> Any:
        """Create a publisher; see `rclpy.node.Node`."""
        if msg_type is ParameterEvent and not self._publishes_parameter_events:
            return SimpleNamespace(publish=lambda event: None)
        if temporary:
            events = PublisherEventCallbacks(use_default_callbacks=False)
            options = {"event_callbacks": events, **options}
        return super().create_publisher(msg_type, topic, *args, **options)

    def destroy_subscription(self, subscription: Any) -> bool:
        """Unsubscribe; see `rclpy.node.Node`."""
        self._check_temporary(subscription)
        return bool(super().destroy_subscription(subscription))

    def destroy_publisher(self, publisher: Any) -> bool:
        """Destroy a publisher; see `rclpy.node.Node`."""
        self._check_temporary(publisher)
        return bool(super().destroy_publisher(publisher))

    def _check_temporary(self, end: Any) -> None:
        executor = self.executor
        if end.event_handlers and executor is not None and self in executor.get_nodes():
            raise ValueError(
                f"{end.topic_name} is destroyed before its node: make it temporary=True"
            )

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
