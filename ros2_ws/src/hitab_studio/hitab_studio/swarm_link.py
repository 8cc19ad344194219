"""The connection to the swarm, in a thread of its own beside the web server.

The thread spins a node, keeps the store up to date, and does what the pages ask for one after the
other. It connects anew whenever the swarm that is meant has been started again.
"""

from __future__ import annotations

import asyncio
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from hitab_msgs.msg import CommanderStatus

from hitab_bringup import names
from hitab_bringup.errors import SwarmError
from hitab_bringup.identity import is_own
from hitab_bringup.ros_link import RosLink
from hitab_bringup.swarm_client import SwarmClient
from hitab_bringup.world_client import WorldClient
from hitab_ros import qos
from hitab_studio.finding import Target
from hitab_studio.markers import Markers
from hitab_studio.recording import Recorder
from hitab_studio.scene import Scene, scene_of
from hitab_studio.store import Store
from hitab_studio.watching import Watch

T = TypeVar("T")

SPIN_SECONDS = 0.01
LOOK_SECONDS = 0.05
FIND_SECONDS = 1.0


@dataclass
class Connected:
    """The swarm, as seen over ROS."""

    link: RosLink
    agents: SwarmClient
    world: WorldClient


class SwarmLink:
    """Talks to the swarm for all pages.

    Args:
        store: what is known is put there.
        find: tells which swarm is meant.
        shown: called in the link's thread with each new moment of the world.
    """

    def __init__(
        self, store: Store, find: Callable[[], Target], shown: Callable[[Scene], None]
    ) -> None:
        self.store = store
        self._find = find
        self._shown = shown
        self._jobs: queue.SimpleQueue[tuple[Callable[[Connected], Any], Future[Any]]] = (
            queue.SimpleQueue()
        )
        self._focus: dict[str, set[str]] = {}
        self._watches: dict[str, Watch] = {}
        self._group_topics: set[str] = set()
        self._recorder: Recorder | None = None
        self._markers: Markers | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="swarm link", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End, and wait for the node to have left."""
        self._stopping.set()
        self._thread.join(10.0)

    # -- called by pages --------------------------------------------------------------------

    async def do(self, job: Callable[[Connected], T]) -> T:
        """Have something done by the link's thread and return what it returns.

        Raises:
            SwarmError: if it cannot be done; the message is for people.
        """
        future: Future[T] = Future()
        self._jobs.put((job, future))
        return await asyncio.wrap_future(future)

    def focus(self, session: str, agents: set[str]) -> None:
        """Look at these agents on behalf of a session; at none: it has gone."""
        if agents:
            self._focus[session] = agents
        else:
            self._focus.pop(session, None)

    def want(self, agent: str, behavior: str) -> None:
        """Ask a watched agent for a behavior of its library."""
        if (watch := self._watches.get(agent)) is not None:
            watch.want(behavior)

    def refresh(self, agent: str) -> None:
        """Ask for the examples of an agent again."""
        if (watch := self._watches.get(agent)) is not None:
            watch.refresh()

    @property
    def recorder(self) -> Recorder | None:
        """What records the run at the moment."""
        return self._recorder

    # -- the thread -------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._stopping.is_set():
            target = self._find()
            self.store.reset(target)
            if target.problem:
                self._wait_for_certainty(target)
                continue
            try:
                with RosLink(target.domain_id) as link:
                    connected = Connected(
                        link,
                        SwarmClient(link, target.agents, identity=target.identity),
                        WorldClient(link, identity=target.identity, started_by_it=target.world),
                    )
                    self._markers = Markers(link)
                    try:
                        self._serve(connected, target)
                    finally:
                        self.stop_recording()  # while its node is there
            except Exception as error:  # the thread must outlive whatever goes wrong
                self.store.target = Target(0, problem=f"The connection was lost: {error}")
                self.store.touch()
                self._stopping.wait(FIND_SECONDS)
            finally:
                self._watches.clear()
                self._group_topics.clear()

    def _wait_for_certainty(self, target: Target) -> None:
        """Refuse all that is asked for until it is certain which swarm is meant."""
        while not self._stopping.is_set() and self._find() == target:
            while not self._jobs.empty():
                _, future = self._jobs.get()
                if future.set_running_or_notify_cancel():
                    future.set_exception(SwarmError(target.problem))
            self._stopping.wait(FIND_SECONDS)

    def _serve(self, connected: Connected, target: Target) -> None:
        next_look = next_find = 0.0
        shown = None
        while not self._stopping.is_set():
            connected.link.spin(SPIN_SECONDS)
            while not self._jobs.empty():
                self._do_next(connected)
            state = connected.world.state
            if state is not None and state is not shown:
                shown = state
                self._see(scene_of(state), state)
            now = time.monotonic()
            if now >= next_look:
                next_look = now + LOOK_SECONDS
                self._look(connected)
            if now >= next_find:
                next_find = now + FIND_SECONDS
                self._housekeeping(connected)
                if self._find() != target:
                    return

    def _do_next(self, connected: Connected) -> None:
        job, future = self._jobs.get()
        if not future.set_running_or_notify_cancel():
            return
        try:
            future.set_result(job(connected))
        except Exception as error:
            future.set_exception(error)
        self.store.touch()

    def _see(self, scene: Scene, state: object) -> None:
        store = self.store
        before = store.scene
        store.scene = scene
        store.situations.see(scene)
        if before is None or (before.mode, before.episode) != (scene.mode, scene.episode):
            store.touch()
        if self._markers is not None:
            self._markers.show(scene, store)
        self._shown(scene)

    def _look(self, connected: Connected) -> None:
        store = self.store
        if connected.world.status is not store.world:
            store.world = connected.world.status
            store.touch()
        statuses = connected.agents.statuses
        if any(store.statuses.get(name) is not status for name, status in statuses.items()):
            store.statuses = dict(statuses)
            store.touch()
            if store.scene is not None and store.scene.mode == "paused":
                self._shown(store.scene)  # what agents do is shown in the field too
        wanted = {agent for agents in list(self._focus.values()) for agent in agents}
        for agent in wanted & statuses.keys() - self._watches.keys():
            self._watches[agent] = Watch(
                connected.link, agent, partial(statuses.get, agent), partial(self._knows, agent)
            )
        for agent in self._watches.keys() - wanted:
            self._watches.pop(agent).close()
        if store.watched.keys() != self._watches.keys():
            store.watched = {name: watch.known for name, watch in self._watches.items()}
            store.touch()
        for agent, watch in self._watches.items():
            watch.look()
            self._keep_situations(agent, watch)

    def _knows(self, agent: str) -> None:
        # At once: in a paused world the next placement is a moment of the same cycle.
        if (watch := self._watches.get(agent)) is not None:
            self._keep_situations(agent, watch)
        self.store.touch()

    def _keep_situations(self, agent: str, watch: Watch) -> None:
        training = watch.known.training
        if training is not None:
            self.store.situations.keep(
                agent, training.name, [(e.number, e.cycle) for e in training.examples]
            )

    def _housekeeping(self, connected: Connected) -> None:
        store, node = self.store, connected.link.node
        connected.agents.discover()
        gone = frozenset(
            name
            for name in connected.agents.statuses
            if node.count_publishers(names.of_agent(name, "status")) == 0
        )
        if gone != store.gone:
            store.gone = gone
            store.touch()
        for topic in connected.link.topics_of_type("hitab_msgs/msg/CommanderStatus"):
            if topic not in self._group_topics:
                self._group_topics.add(topic)
                connected.link.subscribe(CommanderStatus, topic, self._take_group, qos.LATCHED)
        if self._markers is not None:
            self._markers.look()
        if self._recorder is not None:
            self._recorder.look()
            store.recorded = self._recorder.count
            store.touch()

    def _take_group(self, status: CommanderStatus) -> None:
        target = self.store.target
        if target is None or not is_own(status.swarm, target.identity, started_by_it=False):
            return
        self.store.groups = {**self.store.groups, status.commander: status}
        self.store.touch()

    # -- recording; to be called as jobs ----------------------------------------------------

    def start_recording(self, connected: Connected, path: str) -> None:
        """Record all that is said from now on.

        Raises:
            SwarmError: if that is done already, or the file cannot be written.
        """
        if self._recorder is not None:
            raise SwarmError(f"already recording to {self._recorder.path}")
        self._recorder = Recorder(connected.link, path)
        self.store.recording, self.store.recorded = path, 0

    def stop_recording(self) -> str:
        """End the recording and return where it is; "" if there was none."""
        if self._recorder is None:
            return ""
        path = str(self._recorder.path)
        self._recorder.close()
        self._recorder = None
        self.store.recording = ""
        self.store.touch()
        return path
