"""The connection to the swarm: the server's loop spins a node, and observes the swarm with it.

It reconnects whenever the swarm has been restarted. All this belongs to the server's loop, as the
pages do. An error here is shown on the page that caused it, and ends nothing. What pages ask of
the swarm are coroutines (`hitab_ros.call`), each of which goes on whenever the node was spun.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, TypeVar

from hitab_client import RosLink, SwarmError, Training
from hitab_client.identity import STARTED_BY_HAND
from hitab_ros import give_signs_of_operator, names
from hitab_ros.answering import what_went_wrong
from hitab_ros.call import Turns
from hitab_studio.observer import Connected as Connected
from hitab_studio.observer import Observer
from hitab_studio.robots.topics import Options
from hitab_studio.swarm_finder import SwarmTarget
from hitab_studio.swarm_state import SwarmState

T = TypeVar("T")

STUDIO_NODE = "hitab_studio"
SPIN_SECONDS = 0.01
LINK_PERIOD_SECONDS = 0.05
FIND_SECONDS = 1.0
LEAVE_SECONDS = 10.0
ERROR_REPEAT_SECONDS = 10.0
"""Time until the same error is reported again."""

STUDIO_ENDED = "The studio has ended."
UNCONNECTED = (
    "The studio is not connected to a swarm: start one, or choose one, in the middle of the page."
)

FAILURES = 50
"""Consecutive failed turns after which the link reconnects."""


class SwarmLink:
    """Communicates with the swarm for all pages.

    Args:
        find: returns the swarm to connect to.
        tell: called with what is known, whenever that changes.
        complain: called with an error, and the `page` or `agent` whose pages it concerns.
        choose: has a swarm be found from now on, by its run folder.
        options: a person's choice of the robots' topics.

    Attributes:
        pages: those that are open, by id: each with the `agent` that it views, and whether it is
            `connected`.
        colors: of states, in the markers for other viewers.
    """

    def __init__(
        self,
        find: Callable[[], SwarmTarget],
        tell: Callable[[SwarmState], None],
        complain: Callable[..., None],
        choose: Callable[[str], None] = lambda folder: None,
        options: Options | None = None,
    ) -> None:
        self.pages: Mapping[str, Any] = {}
        self.colors: Mapping[str, int] = {}
        self._find = find
        self._tell = tell
        self._complain = complain
        self._choose = choose
        self._options = options
        self._known = SwarmState()
        self._why_not = UNCONNECTED
        self._connected: Connected | None = None
        self._observer: Observer | None = None
        self._of_threads: set[RosLink] = set()
        self._chosen = False
        self._troubles: dict[str, float] = {}
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        """Begin; call this in the server's loop."""
        self._why_not = ""
        self._task = asyncio.create_task(self._run())

    async def stop(self) -> None:
        """Stop, and wait until the node has left."""
        self._why_not = STUDIO_ENDED
        if self._task is not None:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task

    # -- for pages --------------------------------------------------------------------------

    async def ask(self, what: Callable[[Connected], Turns[T]], needs: str = "") -> T:
        """Have a coroutine of the swarm's clients done, and return its result.

        Args:
            what: returns it.
            needs: an agent, or `names.WORLD`: if it falls silent, the coroutine ends; "" if none.

        Raises:
            SwarmError: if it cannot be done; the message is for people.
        """
        swarm = await self._swarm()
        coroutine = what(swarm)
        swarm.asking += 1
        try:
            while True:
                try:
                    coroutine.send(None)
                except StopIteration as end:
                    result: T = end.value
                    return result
                await swarm.spun.wait()
                if swarm.ended:
                    raise SwarmError(swarm.ended)
                if needs in self._known.silent:
                    who = "The world" if needs == names.WORLD else needs
                    raise SwarmError(f"{who} fell silent meanwhile: look whether it was done.")
        finally:
            coroutine.close()
            swarm.asking -= 1
            if self._observer is not None:  # the caller has its answer already
                self._try(self._observer.look)
                self._deliver()

    async def do(self, job: Callable[[Connected], T], agent: str = "") -> T:
        """Call a function that blocks for long, in a thread and with a node of its own.

        Args:
            job: does it with the swarm.
            agent: that is concerned, for the reader.

        Raises:
            SwarmError: if it cannot be done; the message is for people.
        """
        target = (await self._swarm()).target

        def work() -> T:
            with RosLink(target.domain_id, name=STUDIO_NODE) as link:
                self._of_threads.add(link)
                try:
                    return job(Connected.to(target, link))
                finally:
                    self._of_threads.discard(link)

        return await asyncio.to_thread(work)

    async def _swarm(self) -> Connected:
        """Return the swarm, once it is connected to.

        Raises:
            SwarmError: if none is meant.
        """
        while (swarm := self._connected) is None:
            if self._why_not:
                raise SwarmError(self._why_not)
            await asyncio.sleep(SPIN_SECONDS)
        return swarm

    def choose(self, folder: str) -> None:
        """Show the swarm in this run folder from now on, for all pages."""
        self._choose(folder)
        self._chosen = True

    def training(self, agent: str) -> Training | None:
        """Return a viewed agent's training, as published last."""
        swarm = self._connected
        status = swarm.agents.statuses.get(agent) if swarm is not None else None
        if swarm is None or status is None or not status.training:
            return None
        return swarm.agents.trainings.get(agent)

    def want(self, agent: str, behavior: str) -> None:
        """Ask a watched agent for a behavior of its library."""
        if self._observer is not None and agent in self._observer.watches:
            self._observer.watches[agent].want(behavior)

    def probe(self, agent: str, *, on: bool) -> None:
        """Ask a watched agent for the values of all its features from now on, or no longer."""
        if self._observer is not None and agent in self._observer.watches:
            self._observer.watches[agent].probe(on=on)

    @property
    def observer(self) -> Observer:
        """The observer of the swarm.

        Raises:
            SwarmError: if there is no connection.
        """
        if self._observer is None:
            raise SwarmError(self._why_not or UNCONNECTED)
        return self._observer

    # -- the loop ---------------------------------------------------------------------------

    async def _run(self) -> None:
        while True:
            try:
                target = self._find()
                self._begin(target)
                if target.problem:
                    while self._is_still(target):
                        await asyncio.sleep(FIND_SECONDS)
                else:
                    await self._connect(target)
            except Exception as error:  # the loop must outlive whatever goes wrong
                logging.getLogger(__name__).exception("the link to the swarm")
                why = f"The connection was lost: {what_went_wrong(error)}"
                self._begin(SwarmTarget(0, problem=why))
                await asyncio.sleep(FIND_SECONDS)

    def _begin(self, target: SwarmTarget) -> None:
        """Forget the previous swarm: another one, or another start of it, takes its place."""
        self._chosen = False
        self._why_not = target.problem
        before = self._known  # an emergency stop is not the swarm's: it outlasts it
        self._known = SwarmState(
            target,
            before.revision + 1,
            emergency=before.emergency,
            stopped_at=before.stopped_at,
            joined=time.monotonic(),
        )
        self._tell(self._known)

    async def _connect(self, target: SwarmTarget) -> None:
        with await asyncio.to_thread(RosLink, target.domain_id, name=STUDIO_NODE) as link:
            await self._use(target, Connected.to(target, link))

    async def _use(self, target: SwarmTarget, swarm: Connected) -> None:
        why = "The connection was lost meanwhile: look whether it was done."
        try:
            self._observer = Observer(
                swarm,
                self._known,
                self.pages,
                self.colors,
                self._trouble,
                self.ask,
                self._options,
            )
            give_signs_of_operator(
                swarm.link.node,
                target.namespace,
                lambda: any(page.connected for page in self.pages.values()),
            )
            self._connected = swarm
            await self._serve(target, swarm, self._observer)
            why = _gone(target)
        except asyncio.CancelledError:
            why = STUDIO_ENDED
            raise
        finally:
            if self._observer is not None:
                self._try(self._observer.stop_recording)
                self._deliver()
            self._connected = self._observer = None
            swarm.ended = why
            swarm.spun.set()
            for other in list(self._of_threads):
                other.end(why)
            while swarm.asking:
                await asyncio.sleep(0)

    async def _serve(self, target: SwarmTarget, swarm: Connected, observer: Observer) -> None:
        """Spin the node and observe the swarm until another one is meant."""
        failures = 0
        next_look = next_find = 0.0
        while True:
            await asyncio.sleep(SPIN_SECONDS)
            failures = 0 if self._try(lambda: swarm.link.spin(0.0)) else failures + 1
            if failures >= FAILURES:
                raise SwarmError("nothing could be received for a while")
            swarm.spun.set()
            swarm.spun.clear()
            now = time.monotonic()
            self._try(observer.see)
            if now >= next_look:
                next_look = now + LINK_PERIOD_SECONDS
                self._try(observer.look)
            if now >= next_find:
                next_find = now + FIND_SECONDS
                self._try(observer.keep_house)
                if not self._is_still(target):
                    return
            self._deliver()

    def _deliver(self) -> None:
        if self._observer is not None and self._observer.known is not self._known:
            self._known = self._observer.known
            self._tell(self._known)

    def _is_still(self, target: SwarmTarget) -> bool:
        """Whether the same swarm is meant; if that cannot be found out at the moment, it is.

        Nodes that were started by hand are meant while any of them answers, whatever else starts,
        unless a person chooses another swarm.
        """
        found = [target]
        self._try(lambda: found.append(self._find()))
        now = found[-1]
        observer = self._observer
        if observer is None:
            return now == target and now.choices == target.choices
        by_hand = target.identity == STARTED_BY_HAND and not self._chosen
        if now != target and not (by_hand and observer.known.is_anyone_there):
            return False
        observer.may_show(now.choices)
        return True

    def _try(self, work: Callable[[], Any]) -> bool:
        """Call a function and report a failure; return whether it succeeded."""
        try:
            work()
        except Exception as error:
            self._trouble(what_went_wrong(error), error=error)
            return False
        return True

    def _trouble(self, text: str, *, error: Exception | None = None, **whose: str) -> None:
        """Show an error: on a page, on those that view an agent, or on all."""
        now = time.monotonic()
        if now >= self._troubles.get(text, 0.0):
            self._troubles[text] = now + ERROR_REPEAT_SECONDS
            logging.getLogger(__name__).error("%s", text, exc_info=error)
            self._complain(text, **whose)


def _gone(target: SwarmTarget) -> str:
    """Return the error of a job whose swarm has gone."""
    name = f'Swarm "{target.swarm}"' if target.swarm else "The swarm"
    what = "went down meanwhile, was started again, or is not shown any more"
    return f"{name} {what}: look whether it was done."
