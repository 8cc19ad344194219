"""The connection to the swarm: the server's loop spins a node, and observes the swarm with it.

It reconnects whenever the swarm has been restarted. All this belongs to the server's loop, as the
pages do. An error here is shown on the page that caused it, and ends nothing.

Only jobs, requests that wait for the swarm, run in threads. A job is ordinary code that waits by
spinning the link. A job holds the link's monitor except while it waits, so only one thread at
a time uses the node, the clients and their data.

The rule for jobs: wait by the link (`spin`, `spin_until`, `call`), never by sleeping.
"""

from __future__ import annotations

import asyncio
import logging
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, TypeVar

from hitab_client import RosLink, SwarmClient, SwarmError, Training, WorldClient
from hitab_client.identity import STARTED_BY_HAND
from hitab_core import HitabError
from hitab_ros import give_signs_of_operator, names
from hitab_ros.answering import what_went_wrong
from hitab_studio.observer import Observer, Viewing
from hitab_studio.robots.topics import Options
from hitab_studio.swarm_finder import SwarmTarget
from hitab_studio.swarm_state import SwarmState

T = TypeVar("T")

STUDIO_NODE = "hitab_studio"
JOBS_MAX = 64
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

_needs: ContextVar[str | None] = ContextVar("needs", default=None)
"""In a job: the agent or the world that must answer; "" if none."""


class JobError(RuntimeError):
    """A bug in a job, in a form that a future can carry."""


class SharedLink(RosLink):
    """A link for the server's loop and for jobs.

    Attributes:
        monitor: held by the user of the link.
        silent: agents, and the world, that have fallen silent: what needs them ends.
        ended: why all jobs end; "" as long as they go on.
    """

    def __init__(self, domain_id: int | None, *, name: str) -> None:
        super().__init__(domain_id, name=name)
        self.monitor = threading.Condition()
        self.silent: Mapping[str, float] = {}
        self.ended = ""

    def spin(self, seconds: float = 0.1) -> None:
        """Handle events; in a job, have the server's loop do that.

        Raises:
            SwarmError: if the job should end.
        """
        needs = _needs.get()
        if needs is None:
            super().spin(seconds)
            return
        if not self.ended and needs not in self.silent:
            self.monitor.wait(seconds)
        if self.ended:
            raise SwarmError(self.ended)
        if needs in self.silent:
            who = "The world" if needs == names.WORLD else needs
            raise SwarmError(f"{who} fell silent meanwhile: look whether it was done.")

    def end(self, why: str) -> None:
        """End all jobs with an error, wherever they wait."""
        with self.monitor:
            self.ended = why
            self.monitor.notify_all()


@dataclass
class Connected:
    """The swarm, as seen over ROS."""

    link: SharedLink
    agents: SwarmClient
    world: WorldClient

    def run(self, job: Callable[[Connected], T], needs: str) -> T:
        """Do a job; for a thread of its own."""
        token = _needs.set(needs)
        try:
            with self.link.monitor:
                return job(self)
        except HitabError:
            raise
        except BaseException as error:
            # A future cannot carry every exception, and some would end the server's loop.
            raise JobError(f"{type(error).__name__}: {error}") from error
        finally:
            _needs.reset(token)


class SwarmLink:
    """Communicates with the swarm for all pages.

    Args:
        find: returns the swarm to connect to.
        tell: called with what is known, whenever that changes.
        complain: called with an error, and the `session` or `agent` whose pages it concerns.
        choose: has a swarm be found from now on, by its run folder.
        options: a person's choice of the robots' topics.

    Attributes:
        viewing: agents that pages show.
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
        self.viewing = Viewing()
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
        self._lines: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)
        self._threads = ThreadPoolExecutor(JOBS_MAX, "studio job")
        self._jobs: set[asyncio.Future[Any]] = set()
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
        self._threads.shutdown(wait=False, cancel_futures=True)

    # -- for pages --------------------------------------------------------------------------

    async def do(self, job: Callable[[Connected], T], line: str = "", needs: str = "") -> T:
        """Call a function with the swarm in a thread, and return its result.

        Args:
            job: does it.
            line: the agent whose jobs are done one after the other; "" for independent jobs.
            needs: an agent, or `names.WORLD`: if it falls silent, the job ends; "" if none.

        Raises:
            SwarmError: if it cannot be done; the message is for people.
        """
        while (swarm := self._connected) is None:
            if self._why_not:
                raise SwarmError(self._why_not)
            await asyncio.sleep(SPIN_SECONDS)  # it is being connected
        if not line:
            return await self._do(swarm, job, needs)
        async with self._lines[line]:
            return await self._do(swarm, job, needs)

    async def _do(self, swarm: Connected, job: Callable[[Connected], T], needs: str) -> T:
        if swarm.link.ended:
            raise SwarmError(swarm.link.ended)
        loop = asyncio.get_running_loop()
        running = loop.run_in_executor(self._threads, swarm.run, job, needs)
        self._jobs.add(running)
        try:
            return await running
        finally:
            self._jobs.discard(running)
            if self._observer is not None and swarm.link.monitor.acquire(blocking=False):
                try:  # the caller has its answer already
                    self._try(self._observer.look)
                finally:
                    swarm.link.monitor.release()
                self._deliver()

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
        link = await asyncio.to_thread(SharedLink, target.domain_id, name=STUDIO_NODE)
        space, identity = target.namespace, target.identity
        why = "The connection was lost meanwhile: look whether it was done."
        try:
            swarm = Connected(
                link,
                SwarmClient(link, target.agents, prefix=space, identity=identity),
                WorldClient(link, prefix=space, identity=identity, started_by_it=target.world),
            )
            self._observer = Observer(
                link,
                swarm.agents,
                swarm.world,
                self._known,
                self.viewing,
                self.colors,
                self._trouble,
                self.do,
                self._options,
            )
            give_signs_of_operator(link.node, space, lambda: self.viewing.pages)
            self._connected = swarm
            await self._serve(target, swarm, self._observer)
            why = _gone(target)
        except asyncio.CancelledError:
            why = STUDIO_ENDED
            raise
        finally:
            if self._observer is not None:
                with link.monitor:
                    self._try(self._observer.stop_recording)
                self._deliver()
            self._connected = self._observer = None
            link.end(why)
            if self._jobs:
                await asyncio.wait(self._jobs, timeout=LEAVE_SECONDS)
            link.close()

    async def _serve(self, target: SwarmTarget, swarm: Connected, observer: Observer) -> None:
        """Spin the node and observe the swarm until another one is meant."""
        link, failures = swarm.link, 0
        next_look = next_find = 0.0
        while True:
            await asyncio.sleep(SPIN_SECONDS)
            if not link.monitor.acquire(blocking=False):
                continue  # a job is at it
            try:
                failures = 0 if self._try(lambda: link.spin(0.0)) else failures + 1
                if failures >= FAILURES:
                    raise SwarmError("nothing could be received for a while")
                now = time.monotonic()
                self._try(observer.see)
                if now >= next_look:
                    next_look = now + LINK_PERIOD_SECONDS
                    self._try(observer.look)
                    link.silent = observer.known.silent
                if now >= next_find:
                    next_find = now + FIND_SECONDS
                    self._try(observer.keep_house)
                    if not self._is_still(target):
                        return
            finally:
                link.monitor.notify_all()
                link.monitor.release()
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
