"""Calls over ROS: service calls, repeated messages, and waits for conditions.

All calls are coroutines, which yield the time in seconds for which their node may wait for the
next event. `Caller.run` drives one coroutine until it returns, for verbs and scripts. A server's
loop drives any number of coroutines at the same time, after each spin.
"""

from __future__ import annotations

import functools
import time
import types
import uuid
from collections.abc import Callable, Coroutine, Generator
from typing import TYPE_CHECKING, Any, Concatenate, Generic, ParamSpec, Self, TypeVar, overload

from hitab_core import Fix, HitabError
from hitab_ros.busy_timeout import BusyTimeout
from hitab_ros.timing import ANSWER_S, DISCOVERY_S, HEARTBEAT_S, REPEAT_S

if TYPE_CHECKING:
    from hitab_ros.nodes.guarded_node import GuardedNode

S = TypeVar("S")
T = TypeVar("T")
P = ParamSpec("P")

Turns = Coroutine[float, None, T]
"""A coroutine that yields the time for which its node may wait for the next event, s."""


class SwarmError(HitabError):
    """A swarm that does not start, does not answer or refuses."""


class RequestRefused(SwarmError):
    """An answer of a service that has not done what was asked.

    Attributes:
        answer: the answer.
    """

    answer: Any = None


def refused(answer: Any, where: str = "") -> RequestRefused:
    """Return the error for a refusing answer of a service.

    Args:
        answer: the service's answer, with its message and its remedies, if it has such a field.
        where: name of the server, for people.
    """
    from hitab_ros.messages.conversions import (
        remedies_of,  # here because the help imports this module
    )

    remedies = remedies_of(getattr(answer, "remedies", ()))
    error = RequestRefused(answer.message, *remedies, where=where)
    error.answer = answer
    return error


@types.coroutine
def turn(seconds: float) -> Generator[float, None, None]:
    """Let the node handle events; it waits at most this long for one."""
    yield seconds


class Blocking(Generic[P, T]):
    """A blocking method of one object: call it to wait, or await its coroutine."""

    def __init__(self, run: Callable[[Turns[T]], T], coroutine: Callable[P, Turns[T]]) -> None:
        self.coroutine = coroutine
        self._run = run

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> T:
        """Wait for the result."""
        return self._run(self.coroutine(*args, **kwargs))


class blocking(Generic[S, P, T]):
    """Decorator that makes a coroutine method block when called; see `Blocking`.

    The method's object is a `Caller`, or has one as its `link`.
    """

    def __init__(self, coroutine: Callable[Concatenate[S, P], Turns[T]]) -> None:
        self.coroutine = coroutine
        functools.update_wrapper(self, coroutine)

    @overload
    def __get__(self, owner: None, kind: type) -> Self: ...
    @overload
    def __get__(self, owner: S, kind: type) -> Blocking[P, T]: ...
    def __get__(self, owner: S | None, kind: type) -> Self | Blocking[P, T]:
        return self if owner is None else self._of(owner)

    def __call__(self, owner: S, *args: P.args, **kwargs: P.kwargs) -> T:
        """Wait for the result."""
        return self._of(owner)(*args, **kwargs)

    def _of(self, owner: S) -> Blocking[P, T]:
        link: Any = getattr(owner, "link", owner)
        return Blocking(link.run, functools.partial(self.coroutine, owner))


class Caller:
    """Calls services with a node; a base class, whose `spin` handles the node's events.

    Args:
        node: the calling node.
        announce: called with the reason of a wait, once the wait is noticeable.
    """

    def __init__(self, node: GuardedNode, announce: Callable[[str], None] | None = None) -> None:
        self.node = node
        self._announce = announce
        self._announced: set[str] = set()
        self._clients: dict[str, Any] = {}

    def spin(self, seconds: float = 0.1) -> None:
        """Handle pending events; wait at most this long for one."""
        raise NotImplementedError

    def run(self, coroutine: Turns[T]) -> T:
        """Drive a coroutine to its end, and return its result."""
        try:
            while True:
                try:
                    seconds = coroutine.send(None)
                except StopIteration as end:
                    result: T = end.value
                    return result
                self.spin(seconds)
        finally:
            coroutine.close()

    async def until(
        self,
        done: Callable[[], Any],
        seconds: float,
        each: float = 0.05,
        waiting_for: Callable[[], str] | None = None,
    ) -> bool:
        """Wait until ``done()`` is true; return whether it became true in time.

        Args:
            done: the condition.
            seconds: timeout; longer on a busy machine, see `BusyTimeout`.
            each: seconds between two checks, if nothing happens.
            waiting_for: returns the text to announce if the wait is noticeable.
        """
        began, patience = time.monotonic(), BusyTimeout(seconds)
        while not done():
            step = patience.step(each)
            if not step:
                return False
            if waiting_for is not None and time.monotonic() - began > HEARTBEAT_S:
                self._announce_once(f"waiting for {waiting_for()}")
                waiting_for = None
            await turn(step)
        return True

    spin_until = blocking(until)

    def _announce_once(self, text: str) -> None:
        if self._announce is not None and text not in self._announced:
            self._announced.add(text)
            self._announce(text)

    async def repeat(
        self,
        send: Callable[[], Any],
        answered: Callable[[], Any],
        seconds: float,
        period: float,
        *,
        growth: float = 1.0,
        waiting_for: Callable[[], str] | None = None,
        over: Callable[[], bool] = lambda: False,
    ) -> bool:
        """Send a message repeatedly until it is answered; return whether it was in time.

        Args:
            send: sends the message.
            answered: whether there is an answer.
            seconds: timeout for an answer.
            period: seconds until the message is sent again.
            growth: factor by which the period grows each time.
            waiting_for: returns the text to announce if the wait is noticeable.
            over: returns whether to give up, since no answer can arrive.
        """
        deadline = time.monotonic() + seconds
        while (left := deadline - time.monotonic()) > 0 and not over():
            send()
            if await self.until(answered, min(period, left), 0.05, waiting_for):
                return True
            period *= growth
        return bool(answered())

    def will_call(self, kind: Any, service: str) -> None:
        """Prepare to call a service, so that it is discovered while others are called."""
        if service not in self._clients:
            self._clients[service] = self.node.create_client(kind, service)

    @blocking
    async def call(
        self,
        kind: Any,
        service: str,
        request: Any,
        *,
        missing: Callable[[], SwarmError],
        where: str = "",
        seconds: float = ANSWER_S,
        over: Callable[[], bool] = lambda: False,
        heard: Callable[[Any], None] = lambda answer: None,
    ) -> Any:
        """Call a service and return its answer.

        An answer may be lost, for example if the service has not discovered this client yet, so
        the request is repeated until an answer arrives. Requests that change something have an
        id, so that they are carried out only once.

        Args:
            kind: type of the service.
            service: full name of the service.
            request: the request.
            missing: returns the error for a missing service.
            where: name of the server, for people.
            seconds: timeout for the answer.
            over: returns whether to give up, since no answer can arrive.
            heard: called with the answer, also if it is a refusal.

        Raises:
            SwarmError: if the service is missing or does not answer.
            RequestRefused: if it refuses.
        """
        self.will_call(kind, service)
        client = self._clients[service]
        if not await self.until(
            client.service_is_ready, DISCOVERY_S, 0.01, lambda: f"{service} to appear"
        ):
            raise missing()
        if getattr(request, "id", None) == "":
            request.id = uuid.uuid4().hex
        sent: list[Any] = []
        try:
            if not await self.repeat(
                lambda: sent.append(client.call_async(request)),
                lambda: any(future.done() for future in sent),
                seconds,
                REPEAT_S,
                growth=2.0,
                waiting_for=lambda: f"the answer of {service}",
                over=over,
            ):
                late = f"{service} did not answer within {seconds:g} s"
                raise SwarmError(late, Fix.LOGS(node=service.split("/")[-2]))
        finally:
            for future in sent:
                if not future.done():
                    client.remove_pending_request(future)
        answer = next(future.result() for future in sent if future.done())
        heard(answer)
        if not getattr(answer, "success", True):
            raise refused(answer, where)
        return answer
