"""The connection to the swarm, in its own thread beside the web server.

The thread spins a node, observes the swarm, and runs jobs. It reconnects whenever the swarm has
been restarted.

The rule: the two threads share nothing. Everything about ROS belongs to the link's thread,
everything about pages to the server's. The link's thread passes a frozen `Known` when something
has changed; pages pass functions, which the link's thread calls. An error here is shown on the
page that caused it, and ends nothing.
"""

from __future__ import annotations

import asyncio
import logging
import queue
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, TypeVar

from hitab_client import SwarmClient, SwarmError, WorldClient
from hitab_client.identity import BY_HAND
from hitab_ros import names
from hitab_ros.answering import what_went_wrong
from hitab_studio.agent_watch import AgentWatch
from hitab_studio.jobs import Connected, Job, Jobs, SharedLink
from hitab_studio.known import Known, Trouble
from hitab_studio.observer import Observer
from hitab_studio.robots.topics import Options
from hitab_studio.swarm_finder import Target
from hitab_studio.viewing import Viewing

T = TypeVar("T")

NODE = "hitab_studio"
SPIN_SECONDS = 0.01
LOOK_SECONDS = 0.05
FIND_SECONDS = 1.0
AGAIN_SECONDS = 10.0
"""Time until the same error is reported again."""

ENDED = "The studio has ended."
UNCONNECTED = (
    "The studio is not connected to a swarm: start one, or choose one, in the middle of the page."
)

FAILURES = 50
"""Consecutive failed turns after which the link reconnects."""


class SwarmLink:
    """Communicates with the swarm for all pages.

    Args:
        find: returns the swarm to connect to; called in the link's thread.
        tell: called in the link's thread with what is known, whenever that changes, and with
            errors.
        choose: has a swarm be found from now on, by its run folder; called in the link's thread.
        options: what a person has chosen of the robots' topics.
    """

    def __init__(
        self,
        find: Callable[[], Target],
        tell: Callable[[Known | Trouble], None],
        choose: Callable[[str], None] = lambda folder: None,
        options: Options | None = None,
    ) -> None:
        self._find = find
        self._options = options
        self._tell = tell
        self._choose = choose
        self._requests: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="swarm link", daemon=True)
        # From here on: the link's thread alone.
        self._known = self._told = Known()
        self._jobs = Jobs()
        self._connected: Connected | None = None
        self._observer: Observer | None = None
        self._viewing = Viewing()
        self._colors: Mapping[str, int] = {}
        self._next_look = self._next_find = 0.0
        self._chosen = False
        self._troubles: dict[str, float] = {}

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """Stop, and wait until the node has left."""
        self._stopping.set()
        self._thread.join(10.0)

    # -- called by pages --------------------------------------------------------------------

    async def do(
        self, job: Callable[[Connected], T], lines: Iterable[str] = (), needs: str = ""
    ) -> T:
        """Have something done by the link's thread and return what it returns.

        Args:
            job: does it.
            lines: jobs that share one are done one after the other; all others at once.
            needs: an agent, or `names.WORLD`: if it falls silent, the job ends; "" if none.

        Raises:
            SwarmError: if it cannot be done; the message is for people.
        """
        if self._stopping.is_set():
            raise SwarmError(ENDED)
        made = Job(lambda: job(self._swarm()), lines, needs)
        self._requests.put(partial(self._jobs.add, made))
        answer: T = await asyncio.wrap_future(made.answer)
        return answer

    def focus(self, session: str, agents: Iterable[str]) -> None:
        """View these agents on behalf of a session; none means that it has gone."""
        looked_at = frozenset(agents)
        self._requests.put(lambda: self._viewing.look_at(session, looked_at))

    def connect(self, session: str, *, on: bool) -> None:
        """Note that a page is connected from now on, or no longer."""
        self._requests.put(lambda: self._viewing.connect(session, on=on))

    def want(self, agent: str, behavior: str) -> None:
        """Ask a watched agent for a behavior of its library."""
        self._requests.put(lambda: self._with_watch(agent, lambda watch: watch.want(behavior)))

    def probe(self, agent: str, *, on: bool) -> None:
        """Ask a watched agent for the values of all its features from now on, or no longer."""
        self._requests.put(lambda: self._with_watch(agent, lambda watch: watch.probe(on=on)))

    def refresh(self, agent: str) -> None:
        """Ask for the examples of an agent again."""
        self._requests.put(lambda: self._with_watch(agent, AgentWatch.refresh))

    def choose(self, folder: str) -> None:
        """Show the swarm in this run folder from now on, for all pages."""

        def change() -> None:
            self._choose(folder)
            self._chosen = True
            self._next_find = 0.0

        self._requests.put(change)

    def paint(self, colors: Mapping[str, int]) -> None:
        """Give states these colors in the markers for other viewers."""
        self._requests.put(lambda: setattr(self, "_colors", colors))

    # -- the thread -------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._stopping.is_set():
            why = "The connection was lost meanwhile: look whether it was done."
            try:
                target = self._find()
                self._begin(target)
                if target.problem:
                    self._wait_for_certainty(target)
                    continue
                with SharedLink(target.domain_id, name=NODE) as link:
                    self._connected = Connected(
                        link,
                        SwarmClient(
                            link,
                            target.agents,
                            prefix=target.namespace,
                            identity=target.identity,
                        ),
                        WorldClient(
                            link,
                            prefix=target.namespace,
                            identity=target.identity,
                            started_by_it=target.world,
                        ),
                    )
                    self._observer = Observer(
                        self._connected,
                        self._known,
                        self._viewing,
                        self._trouble,
                        self._options,
                    )
                    try:
                        self._serve(target)
                        why = ENDED if self._stopping.is_set() else _gone(target)
                    finally:
                        self._end(why)  # while its node is there
            except Exception as error:  # the thread must outlive whatever goes wrong
                logging.getLogger(__name__).exception("the link to the swarm")
                why = f"The connection was lost: {what_went_wrong(error)}"
                self._begin(Target(0, problem=why))
                self._end(why)
                self._stopping.wait(FIND_SECONDS)
        self._end(ENDED)

    def _begin(self, target: Target) -> None:
        """Forget the previous swarm: another one, or another start of it, takes its place."""
        self._next_look = self._next_find = 0.0
        self._chosen = False
        known = self._known  # an emergency stop is not the swarm's: it outlasts it
        self._known = Known(
            target, known.revision + 1, emergency=known.emergency, joined=time.monotonic()
        )
        self._deliver()

    def _end(self, why: str) -> None:
        """End all jobs."""
        self._take_requests()
        if self._observer is not None:
            self._try(self._observer.stop_recording)
        self._deliver()
        for job in self._jobs.end(why):
            job.reply()
        self._connected = self._observer = None

    def _wait_for_certainty(self, target: Target) -> None:
        """Refuse all requests until the swarm is known."""
        while not self._stopping.is_set() and self._is_still(target):
            self._end(target.problem)
            self._stopping.wait(FIND_SECONDS)

    def _swarm(self) -> Connected:
        if self._connected is None:
            raise SwarmError(UNCONNECTED)
        return self._connected

    def _observing(self) -> Observer:
        if self._observer is None:
            raise SwarmError(UNCONNECTED)
        return self._observer

    def _with_watch(self, agent: str, do: Callable[[AgentWatch], None]) -> None:
        if self._observer is not None:
            self._observer.with_watch(agent, do)

    def _deliver(self) -> None:
        if self._observer is not None:
            self._known = self._observer.known
        if self._known is not self._told:
            self._told = self._known
            self._tell(self._known)

    def _serve(self, target: Target) -> None:
        failures = 0
        observer = self._observing()
        while not self._stopping.is_set():
            if self._try(lambda: self._swarm().link.spin(SPIN_SECONDS)):
                failures = 0
            elif (failures := failures + 1) < FAILURES:
                self._stopping.wait(SPIN_SECONDS)
            else:
                raise SwarmError("nothing could be received for a while")
            self._take_requests()
            ended = self._jobs.go_on()
            now = time.monotonic()
            observer.colors = self._colors
            self._try(observer.see)
            if ended or now >= self._next_look:
                self._next_look = now + LOOK_SECONDS
                self._try(observer.look)
                for name in observer.known.silent:
                    ended += self._jobs.end_those_that_need(name, _silent(name))
            if now >= self._next_find:
                self._next_find = now + FIND_SECONDS
                self._try(observer.keep_house)
                if not self._is_still(target):
                    return
            self._deliver()
            for job in ended:  # whoever asked knows by now what there is to be known
                job.reply()

    def _is_still(self, target: Target) -> bool:
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
        if now == target:
            observer.may_show(now.choices)
            return True
        if target.identity != BY_HAND or self._chosen or not observer.known.is_anyone_there:
            return False
        observer.may_show(now.choices)
        return True

    def _take_requests(self) -> None:
        while not self._requests.empty():
            self._try(self._requests.get())

    def _try(self, work: Callable[[], Any]) -> bool:
        """Call a function and report a failure; return whether it succeeded."""
        try:
            work()
        except Exception as error:
            self._trouble("", what_went_wrong(error), error)
            return False
        return True

    def _trouble(
        self, agent: str, text: str, error: Exception | None = None, session: str = ""
    ) -> None:
        """Show an error: on a page, on those that view an agent, or on all."""
        now = time.monotonic()
        if now < self._troubles.get(text, 0.0):
            return
        self._troubles[text] = now + AGAIN_SECONDS
        logging.getLogger(__name__).error("%s", text, exc_info=error)
        self._tell(Trouble(text, session, agent))

    # -- to be called as jobs ---------------------------------------------------------------

    def stop_robots(self, engaged: bool, by: str, reason: str = "") -> list[str]:
        """Stop all robots, or release them; return who listens.

        Raises:
            SwarmError: if there is no connection.
        """
        return self._observing().stop_robots(engaged, by, reason)

    def arm(self, agent: str) -> None:
        """Let an agent's robot act again; to be called as a job.

        Raises:
            SwarmError: if it may not.
        """
        self._observing().arm(agent)

    # -- recording; to be called as jobs ----------------------------------------------------

    def start_recording(self, path: str, session: str = "") -> None:
        """Record all messages from now on.

        Raises:
            SwarmError: if a recording is running, or the file cannot be written.
        """
        self._observing().start_recording(path, session)

    def stop_recording(self) -> str:
        """End the recording and return its path; "" if there was none.

        Raises:
            SwarmError: if its end could not be written.
        """
        return self._observing().stop_recording()


def _silent(name: str) -> str:
    """Return the error of a job that needs an agent, or the world, that has fallen silent."""
    who = "The world" if name == names.WORLD else name
    return f"{who} fell silent meanwhile: look whether it was done."


def _gone(target: Target) -> str:
    """Return the error of a job whose swarm has gone."""
    name = f'Swarm "{target.swarm}"' if target.swarm else "The swarm"
    what = "went down meanwhile, was started again, or is not shown any more"
    return f"{name} {what}: look whether it was done."
