"""Guard around every callback of every node.

An exception that leaves a callback ends the process (rclpy's EventsExecutor) and all its nodes. A
guarded callback logs its exception with the trace, once per cause, and lists it among the node's
faults until the callback succeeds again.
"""

from __future__ import annotations

import functools
import inspect
import traceback
from collections.abc import Callable
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from hitab_core import HitabError
from hitab_ros.answering import refuse, remedies_for, what_went_wrong
from hitab_ros.messages.checks import MESSAGE_BYTES_MAX, BadMessage, check
from hitab_ros.nodes.faults import Faults
from hitab_ros.nodes.sparing_log import SparingLog

TRACE_MAX = 6000
"""Maximum characters of a logged trace."""


class _Guarding:
    """Reusable context manager that catches and reports exceptions."""

    def __init__(self, guard: Guard, key: str) -> None:
        self._guard = guard
        self._key = key

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> bool:
        faults = self._guard.faults
        if isinstance(error, Exception):
            self._guard.failed(self._key, error)
            return True
        if error is None and self._key in faults.by_key:
            faults.clear(self._key)
        return False


class Guard:
    """Runs callbacks so that their exceptions do not end the process.

    Attributes:
        faults: faults of the callbacks' node.
        log: rate-limited log of failures and of received text.
    """

    def __init__(self, write: Callable[[str], None]) -> None:
        """Create a guard.

        Args:
            write: writes to the node's log.
        """
        self.faults = Faults()
        self.log = SparingLog(write)

    def failed(self, key: str, error: Exception) -> None:
        """Log an error, once per cause, and list a fault until the callback succeeds.

        Args:
            key: name of the failed activity, such as ``topic command``.
            error: the exception.
        """
        places = traceback.extract_tb(error.__traceback__)
        place = (places[-1].filename, places[-1].lineno) if places else ("", 0)
        text = f"{key} failed: {what_went_wrong(error)}"
        if not isinstance(error, HitabError):
            trace = "".join(traceback.format_exception(error))
            self.log(f"{text}\n{trace}", (key, type(error), place), TRACE_MAX)
        else:
            self.log(f"{key} failed: {error}")
        self.faults.set(key, text, *remedies_for(error))

    def run(self, key: str, call: Callable[..., Any], *arguments: Any) -> bool:
        """Call a function; return whether it succeeded instead of raising.

        Args:
            key: name of the activity.
            call: the function; its result is ignored.
            arguments: arguments of the function.
        """
        with _Guarding(self, key):
            call(*arguments)
            return True
        return False

    def wrap(
        self, key: str, callback: Callable[..., Any], otherwise: Any = None
    ) -> Callable[..., Any]:
        """Return a callback that returns ``otherwise`` instead of raising."""
        guarding = _Guarding(self, key)

        @functools.wraps(callback)
        async def guarded_coroutine(*arguments: Any) -> Any:
            with guarding:
                return await callback(*arguments)
            return otherwise

        @functools.wraps(callback)
        def guarded(*arguments: Any) -> Any:
            with guarding:
                return callback(*arguments)
            return otherwise

        return guarded_coroutine if inspect.iscoroutinefunction(callback) else guarded

    def wrap_topic(
        self,
        key: str,
        kind: Any,
        callback: Callable[..., Any],
        *,
        checked: bool = True,
        read: Callable[[bytes], Any] | None = None,
    ) -> Callable[..., Any]:
        """Return the callback of a raw subscription, which never raises.

        An invalid message (see `hitab_ros.messages.checks`) is dropped and logged once; it is not
        a fault of the node. A message that is too large is dropped before deserialization.

        Args:
            key: name of the topic.
            kind: type of the messages; None if the callback takes their bytes.
            callback: takes a message, or a message and information about it.
            checked: whether to check messages; otherwise the callback must do so.
            read: returns a message, or an object with its fields, from its bytes, or None to skip
                it; None for rclpy's own conversion.
        """
        guarded = self.wrap(key, callback)
        read = read or functools.partial(deserialize_message, message_type=kind)

        @functools.wraps(callback)
        def read_and_guarded(*arguments: Any) -> Any:
            # rclpy's EventsExecutor passes one tuple where other executors pass two arguments.
            message, *information = arguments[0] if type(arguments[0]) is tuple else arguments
            try:
                if kind is not None:
                    if (size := len(message)) > MESSAGE_BYTES_MAX:
                        raise BadMessage(
                            f"it has {size:,} bytes; the limit is {MESSAGE_BYTES_MAX:,}; "
                            "send less at once"
                        )
                    message = read(message)
                if message is None:
                    return None
                if checked:
                    check(message, kind)
            except (BadMessage, RuntimeError) as error:  # rclpy's own error is a RuntimeError
                self.log(f"{key}: dropped an invalid message: {error}", key)
                return None
            return guarded(message, *information)

        return read_and_guarded

    def wrap_service(self, key: str, serve: Callable[..., Any]) -> Callable[..., Any]:
        """Return a service callback that always returns a valid response.

        If ``serve`` raises, or returns an invalid response, the response has ``success`` false and
        the reason in ``message``, if it has these fields. A `HitabError` is the caller's mistake
        and not a fault of the node.
        """

        @functools.wraps(serve)
        def guarded(request: Any, response: Any) -> Any:
            try:
                check(request)
                answer = serve(request, response)
                serialize_message(answer)
            except BadMessage as error:
                self.log(f"{key}: refused a request: {error}", key)
                return refuse(type(response)(), error)
            except HitabError as error:
                return refuse(type(response)(), error)
            except Exception as error:
                self.failed(key, error)
                return refuse(type(response)(), error)
            if key in self.faults.by_key:
                self.faults.clear(key)
            return answer

        return guarded
