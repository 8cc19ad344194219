"""The connection to the swarm, in a thread of its own beside the web server.

The thread spins a node, finds out what is to be known, and gives jobs their turns. It connects
anew whenever the swarm that is meant has been started again.

The rule: the two threads share nothing. All that has to do with ROS belongs to the link's thread,
all that has to do with pages to the server's. The link's thread hands over a frozen `Known` when
something has changed; pages hand over functions, which the link's thread calls. Whatever goes
wrong here is shown on the page that caused it, and ends nothing.
"""

from __future__ import annotations

import asyncio
import logging
import queue
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, TypeVar

from hitab_msgs.msg import CommanderStatus

from hitab_bringup import names
from hitab_bringup.errors import SwarmError
from hitab_bringup.identity import is_own
from hitab_bringup.swarm_client import SwarmClient
from hitab_bringup.world_client import WorldClient
from hitab_ros import qos
from hitab_ros.answering import what_went_wrong
from hitab_studio.finding import Target
from hitab_studio.jobs import Job, Jobs, SharedLink
from hitab_studio.known import Known, Trouble
from hitab_studio.markers import Markers
from hitab_studio.recording import Recorder
from hitab_studio.scene import scene_of
from hitab_studio.situations import Situations
from hitab_studio.watching import Watch

T = TypeVar("T")

SPIN_SECONDS = 0.01
LOOK_SECONDS = 0.05
FIND_SECONDS = 1.0
AGAIN_SECONDS = 10.0
"""Until the same trouble is told again."""

ENDED = "The studio has ended."

FAILURES = 50
"""Turns in a row that fail before the link connects anew."""


@dataclass
class Connected:
    """The swarm, as seen over ROS."""

    link: SharedLink
    agents: SwarmClient
    world: WorldClient


class SwarmLink:
    """Talks to the swarm for all pages.

    Args:
        find: tells which swarm is meant.
        tell: called in the link's thread with what is known, whenever that changes, and with what
            goes wrong.
    """

    def __init__(
        self, find: Callable[[], Target], tell: Callable[[Known | Trouble], None]
    ) -> None:
        self._find = find
        self._tell = tell
        self._requests: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="swarm link", daemon=True)
        # From here on: the link's thread alone.
        self._known = self._told = Known()
        self._jobs = Jobs()
        self._situations = Situations()
        self._connected: Connected | None = None
        self._focus: dict[str, frozenset[str]] = {}
        self._watches: dict[str, Watch] = {}
        self._group_topics: set[str] = set()
        self._recorder: Recorder | None = None
        self._recording_page = ""
        self._markers: Markers | None = None
        self._colors: Mapping[str, int] = {}
        self._shown: object = None
        self._next_look = self._next_find = 0.0
        self._troubles: dict[str, float] = {}

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End, and wait for the node to have left."""
        self._stopping.set()
        self._thread.join(10.0)

    # -- called by pages --------------------------------------------------------------------

    async def do(self, job: Callable[[Connected], T], lines: Iterable[str] = ()) -> T:
        """Have something done by the link's thread and return what it returns.

        Args:
            job: does it.
            lines: jobs that have one in common are done one after the other; all others at once.

        Raises:
            SwarmError: if it cannot be done; the message is for people.
        """
        if self._stopping.is_set():
            raise SwarmError(ENDED)
        made = Job(lambda: job(self._swarm()), lines)
        self._requests.put(partial(self._jobs.add, made))
        answer: T = await asyncio.wrap_future(made.answer)
        return answer

    def focus(self, session: str, agents: Iterable[str]) -> None:
        """Look at these agents on behalf of a session; at none: it has gone."""
        looked_at = frozenset(agents)

        def change() -> None:
            if looked_at:
                self._focus[session] = looked_at
            else:
                self._focus.pop(session, None)

        self._requests.put(change)

    def want(self, agent: str, behavior: str) -> None:
        """Ask a watched agent for a behavior of its library."""
        self._requests.put(lambda: self._with_watch(agent, lambda watch: watch.want(behavior)))

    def refresh(self, agent: str) -> None:
        """Ask for the examples of an agent again."""
        self._requests.put(lambda: self._with_watch(agent, Watch.refresh))

    def paint(self, colors: Mapping[str, int]) -> None:
        """Give states these colors in what others than pages are shown."""
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
                with SharedLink(target.domain_id) as link:
                    self._connected = Connected(
                        link,
                        SwarmClient(link, target.agents, identity=target.identity),
                        WorldClient(link, identity=target.identity, started_by_it=target.world),
                    )
                    self._markers = Markers(link)
                    try:
                        self._serve(target)
                        why = ENDED if self._stopping.is_set() else _gone(target)
                    finally:
                        self._end(why)  # while its node is there
            except Exception as error:  # the thread must outlive whatever goes wrong
                logging.getLogger(__name__).exception("the link to the swarm")
                why = f"The connection was lost: {what_went_wrong(error)}"
                self._know(target=Target(0, problem=why))
                self._end(why)
                self._stopping.wait(FIND_SECONDS)
        self._end(ENDED)

    def _begin(self, target: Target) -> None:
        """Forget the swarm before: another one is meant from now on, or another start of it."""
        self._situations = Situations()
        self._shown, self._next_look, self._next_find = None, 0.0, 0.0
        self._known = Known(target, self._known.revision + 1)
        self._deliver()

    def _end(self, why: str) -> None:
        """End what is under way."""
        self._take_requests()
        self._try(self.stop_recording)
        self._deliver()
        for job in self._jobs.end(why):
            job.reply()
        self._watches.clear()
        self._group_topics.clear()
        self._connected = self._markers = None

    def _wait_for_certainty(self, target: Target) -> None:
        """Refuse all that is asked for until it is certain which swarm is meant."""
        while not self._stopping.is_set() and self._is_still(target):
            self._end(target.problem)
            self._stopping.wait(FIND_SECONDS)

    def _swarm(self) -> Connected:
        if self._connected is None:
            raise SwarmError("The studio is not connected to a swarm.")
        return self._connected

    def _serve(self, target: Target) -> None:
        failures = 0
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
            self._try(self._see)
            if ended or now >= self._next_look:
                self._next_look = now + LOOK_SECONDS
                self._try(self._look)
            if now >= self._next_find:
                self._next_find = now + FIND_SECONDS
                self._try(self._keep_house)
                if not self._is_still(target):
                    return
            self._deliver()
            for job in ended:  # whoever asked knows by now what there is to be known
                job.reply()

    def _is_still(self, target: Target) -> bool:
        """Whether the same swarm is meant; if that cannot be found out at the moment, it is."""
        found = [target]
        self._try(lambda: found.append(self._find()))
        return found[-1] == target

    def _take_requests(self) -> None:
        while not self._requests.empty():
            self._try(self._requests.get())

    def _try(self, work: Callable[[], Any]) -> bool:
        """Do something and tell if it goes wrong; return whether it went well."""
        try:
            work()
        except Exception as error:
            self._trouble("", what_went_wrong(error), error)
            return False
        return True

    def _trouble(
        self, agent: str, text: str, error: Exception | None = None, session: str = ""
    ) -> None:
        """Show what failed: on a page, on those that look at an agent, or else on all."""
        now = time.monotonic()
        if now < self._troubles.get(text, 0.0):
            return
        self._troubles[text] = now + AGAIN_SECONDS
        logging.getLogger(__name__).error("%s", text, exc_info=error)
        self._tell(Trouble(text, session, agent))

    # -- what is known ----------------------------------------------------------------------

    def _know(self, **changes: Any) -> None:
        """Know this, which pages show, from now on."""
        self._known = replace(self._known, revision=self._known.revision + 1, **changes)

    def _deliver(self) -> None:
        if self._known is not self._told:
            self._told = self._known
            self._tell(self._known)

    def _see(self) -> None:
        state = self._swarm().world.state
        if state is None or state is self._shown:
            return
        self._shown = state
        before, scene = self._known.scene, scene_of(state)
        self._situations.see(scene)
        if before is None or (before.mode, before.episode) != (scene.mode, scene.episode):
            self._know(scene=scene)
        else:
            self._known = replace(self._known, scene=scene)
        if self._markers is not None:
            self._markers.show(scene, self._known.doing(), self._colors)

    def _look(self) -> None:
        swarm, known = self._swarm(), self._known
        if swarm.world.status is not known.world:
            self._know(world=swarm.world.status)
        statuses = swarm.agents.statuses
        if any(known.statuses.get(name) is not status for name, status in statuses.items()):
            self._know(statuses=MappingProxyType(dict(statuses)))
        wanted = {agent for agents in self._focus.values() for agent in agents}
        for agent in wanted & statuses.keys() - self._watches.keys():
            self._watches[agent] = Watch(
                swarm.link,
                agent,
                partial(statuses.get, agent),
                partial(self._learns, agent),
                partial(self._trouble, agent),
            )
        for agent in self._watches.keys() - wanted:
            self._watches.pop(agent).close()
        for agent, watch in self._watches.items():
            watch.look()
            self._keep_situations(agent, watch)
        watched = {name: watch.known for name, watch in self._watches.items()}
        if watched.keys() != known.watched.keys():
            self._know(watched=MappingProxyType(watched))
        elif any(known.watched[name] is not it for name, it in watched.items()):
            self._known = replace(self._known, watched=MappingProxyType(watched))

    def _learns(self, agent: str) -> None:
        # At once: in a paused world the next placement is a moment of the same cycle.
        self._with_watch(agent, partial(self._keep_situations, agent))
        watched = {name: watch.known for name, watch in self._watches.items()}
        self._know(watched=MappingProxyType(watched))

    def _keep_situations(self, agent: str, watch: Watch) -> None:
        training = watch.known.training
        if training is not None:
            self._situations.keep(
                agent, training.name, [(e.number, e.cycle) for e in training.examples]
            )
            if self._situations.kept is not self._known.moments:
                self._know(moments=self._situations.kept)

    def _with_watch(self, agent: str, do: Callable[[Watch], None]) -> None:
        if (watch := self._watches.get(agent)) is not None:
            do(watch)

    def _keep_house(self) -> None:
        swarm = self._swarm()
        node = swarm.link.node
        swarm.agents.discover()
        gone = frozenset(
            name
            for name in swarm.agents.statuses
            if node.count_publishers(names.of_agent(name, "status")) == 0
        )
        if gone != self._known.gone:
            self._know(gone=gone)
        for topic in swarm.link.topics_of_type("hitab_msgs/msg/CommanderStatus"):
            if topic not in self._group_topics:
                self._group_topics.add(topic)
                swarm.link.subscribe(CommanderStatus, topic, self._take_group, qos.LATCHED)
        if self._markers is not None:
            self._markers.look()
        if self._recorder is not None:
            self._recorder.look()
            self._know(recorded=self._recorder.count)
            if self._recorder.problem:
                self._trouble("", self._recorder.problem, session=self._recording_page)
                self.stop_recording()

    def _take_group(self, status: CommanderStatus) -> None:
        target = self._known.target
        if target is None or not is_own(status.swarm, target.identity, started_by_it=False):
            return
        self._know(groups=MappingProxyType({**self._known.groups, status.commander: status}))

    # -- recording; to be called as jobs ----------------------------------------------------

    def start_recording(self, connected: Connected, path: str, session: str = "") -> None:
        """Record all that is said from now on.

        Raises:
            SwarmError: if that is done already, or the file cannot be written.
        """
        if self._recorder is not None:
            raise SwarmError(f"already recording to {self._recorder.path}")
        self._recorder = Recorder(connected.link, path)
        self._recording_page = session
        self._know(recording=path, recorded=0)

    def stop_recording(self) -> str:
        """End the recording and return where it is; "" if there was none.

        Raises:
            SwarmError: if its end could not be written.
        """
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return ""
        self._know(recording="")
        recorder.close()
        return str(recorder.path)


def _gone(target: Target) -> str:
    """Say why nothing more comes of a job."""
    name = f'Swarm "{target.swarm}"' if target.swarm else "The swarm"
    return f"{name} went down meanwhile, or was started again: look whether it was done."
