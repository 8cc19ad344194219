"""The connection to the swarm: a node that is spun by the server's loop, and an observer.

The link reconnects after a restart of the swarm. Link and pages run in the server's loop. Requests
of pages are coroutines (`hitab_ros.call`), each resumed after every spin of the node. An error is
shown on the page that caused it, and does not end the link.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, TypeVar

from hitab_client import RosLink, SwarmError, Training
from hitab_client.connecting.identity import STARTED_BY_HAND
from hitab_ros import give_signs_of_operator, names
from hitab_ros.answering import what_went_wrong
from hitab_ros.call import Turns
from hitab_ros.timing import AT_ONCE_S, REMIND_S, REPEAT_S, TURN_S
from hitab_studio.field.last_minute import Minute
from hitab_studio.field.scene_reader import SceneReader
from hitab_studio.robots.topics import Options
from hitab_studio.swarm.observer import Connected as Connected
from hitab_studio.swarm.observer import Observer
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState

T = TypeVar("T")

STUDIO_NODE = "hitab_studio"

STUDIO_ENDED = "The studio has ended."
UNCONNECTED = (
    "The studio is not connected to a swarm: start one, or choose one, in the middle of the page."
)

FAILURES_MAX = 50
"""Consecutive failed spins after which the link reconnects."""


class SwarmLink:
    """Communicates with the swarm for all pages.

    Args:
        find: returns the swarm to connect to.
        tell: called with the state of the swarm after each change.
        complain: called with an error message and, if it concerns only some pages, the `page` or
            their `agent`.
        choose: switches to another swarm, given its run folder.
        options: the chosen topics of robots.

    Attributes:
        pages: the open pages, by id; `agent` is the viewed agent, and `connected` is true while
            a browser shows the page.
        colors: colors of states, by name, for the markers.
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
        self._problem = UNCONNECTED
        self._connected: Connected | None = None
        self._observer: Observer | None = None
        self._job_links: set[RosLink] = set()
        self._chosen = False
        self._next_reports: dict[str, float] = {}
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        """Start connecting; to be called in the server's loop."""
        self._problem = ""
        self._task = asyncio.create_task(self._run())

    async def stop(self) -> None:
        """Disconnect, and wait until the node is destroyed."""
        self._problem = STUDIO_ENDED
        if self._task is not None:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task

    # -- for pages --------------------------------------------------------------------------

    async def ask(self, what: Callable[[Connected], Turns[T]], needs: str = "") -> T:
        """Run a coroutine of the swarm's clients, and return its result.

        Args:
            what: returns the coroutine.
            needs: the agent or `names.WORLD` whose silence ends the coroutine; "" if none.

        Raises:
            SwarmError: if the request fails; the message is for people.
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
                    raise SwarmError(f"{who} fell silent meanwhile: check whether it was done.")
        finally:
            coroutine.close()
            swarm.asking -= 1
            if self._observer is not None:  # show the result with the answer, not a period later
                self._try(self._observer.look)
                self._deliver()

    async def do(self, job: Callable[[Connected], T], agent: str = "") -> T:
        """Call a function that blocks for a long time, in a separate thread with a separate node.

        Args:
            job: called with a connection to the swarm.
            agent: the agent of the job, for readers of the code.

        Raises:
            SwarmError: if there is no swarm, or from the job; the message is for people.
        """
        target = (await self._swarm()).target

        def work() -> T:
            with RosLink(target.domain_id, name=STUDIO_NODE) as link:
                self._job_links.add(link)
                try:
                    return job(Connected.to(target, link))
                finally:
                    self._job_links.discard(link)

        return await asyncio.to_thread(work)

    async def _swarm(self) -> Connected:
        """Return the connection to the swarm, once established.

        Raises:
            SwarmError: if there is no swarm to connect to.
        """
        while (swarm := self._connected) is None:
            if self._problem:
                raise SwarmError(self._problem)
            await asyncio.sleep(TURN_S)
        return swarm

    def choose(self, folder: str) -> None:
        """Switch all pages to the swarm in this run folder."""
        self._choose(folder)
        self._chosen = True

    def training(self, agent: str) -> Training | None:
        """Return the last published training of a viewed agent; None if not training."""
        swarm = self._connected
        status = swarm.agents.statuses.get(agent) if swarm is not None else None
        if swarm is None or status is None or not status.training.automaton:
            return None
        return swarm.agents.trainings.get(agent)

    def want(self, agent: str, behavior: str) -> None:
        """Request a behavior from the library of a watched agent."""
        if self._observer is not None and agent in self._observer.watches:
            self._observer.watches[agent].want(behavior)

    def probe(self, agent: str, *, on: bool) -> None:
        """Start or stop reading all features of a watched agent."""
        if self._observer is not None and agent in self._observer.watches:
            self._observer.watches[agent].probe(on=on)

    @property
    def minute(self) -> Minute:
        """The last minute of the swarm; empty without a connection."""
        return self._observer.minute if self._observer is not None else Minute()

    @property
    def observer(self) -> Observer:
        """The observer of the swarm.

        Raises:
            SwarmError: if there is no connection.
        """
        if self._observer is None:
            raise SwarmError(self._problem or UNCONNECTED)
        return self._observer

    # -- the loop ---------------------------------------------------------------------------

    async def _run(self) -> None:
        while True:
            try:
                target = self._find()
                self._begin(target)
                if target.problem:
                    while self._is_still(target):
                        await asyncio.sleep(REPEAT_S)
                else:
                    await self._connect(target)
            except Exception as error:  # the loop must survive any error
                logging.getLogger(__name__).exception("the link to the swarm")
                why = f"The connection was lost: {what_went_wrong(error)}"
                self._begin(SwarmTarget(0, problem=why))
                await asyncio.sleep(REPEAT_S)

    def _begin(self, target: SwarmTarget) -> None:
        """Reset the known state for another swarm, or for another start of the same swarm."""
        self._chosen = False
        self._problem = target.problem
        before = self._known  # an emergency stop stays engaged when the swarm ends
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
            await self._use(target, Connected.to(target, link, SceneReader()))

    async def _use(self, target: SwarmTarget, swarm: Connected) -> None:
        why = "The connection was lost meanwhile: check whether it was done."
        try:
            self._observer = Observer(
                swarm,
                self._known,
                self.pages,
                self.colors,
                self._report,
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
            why = _swarm_ended(target)
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
            for other in list(self._job_links):
                other.end(why)
            while swarm.asking:
                await asyncio.sleep(0)

    async def _serve(self, target: SwarmTarget, swarm: Connected, observer: Observer) -> None:
        """Spin the node and observe the swarm until the swarm ends or is replaced."""
        failures = 0
        next_look = next_find = 0.0
        while True:
            await asyncio.sleep(TURN_S)
            failures = 0 if self._try(lambda: swarm.link.spin(0.0)) else failures + 1
            if failures >= FAILURES_MAX:
                raise SwarmError("nothing could be received for a while")
            swarm.spun.set()
            swarm.spun.clear()
            now = time.monotonic()
            self._try(observer.see)
            if now >= next_look:
                next_look = now + AT_ONCE_S
                self._try(observer.look)
            if now >= next_find:
                next_find = now + REPEAT_S
                self._try(observer.discover)
                if not self._is_still(target):
                    return
            self._deliver()

    def _deliver(self) -> None:
        if self._observer is not None and self._observer.known is not self._known:
            self._known = self._observer.known
            self._tell(self._known)

    def _is_still(self, target: SwarmTarget) -> bool:
        """Whether the target is still to be shown; true also if the search fails for a moment.

        Nodes that were started by hand are shown while any of them answers, unless a person
        chooses another swarm.
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
        """Call a function and show any error; return whether the function succeeded."""
        try:
            work()
        except Exception as error:
            self._report(what_went_wrong(error), error=error)
            return False
        return True

    def _report(self, text: str, *, error: Exception | None = None, **whose: str) -> None:
        """Show an error on one page, on the pages that view an agent, or on all pages."""
        now = time.monotonic()
        if now >= self._next_reports.get(text, 0.0):
            self._next_reports[text] = now + REMIND_S
            logging.getLogger(__name__).error("%s", text, exc_info=error)
            self._complain(text, **whose)


def _swarm_ended(target: SwarmTarget) -> str:
    """Return the error of a request whose swarm has ended."""
    name = f'Swarm "{target.swarm}"' if target.swarm else "The swarm"
    what = "was stopped, restarted or replaced on this page meanwhile"
    return f"{name} {what}: check whether it was done."
