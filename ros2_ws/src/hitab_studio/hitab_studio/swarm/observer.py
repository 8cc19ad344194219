"""Observes the connected swarm."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import Any

from hitab_msgs.msg import TransitionEvent

from hitab_client import (
    CommanderView,
    RosLink,
    Stops,
    SwarmClient,
    SwarmError,
    WorldClient,
)
from hitab_client.connecting.identity import STARTED_BY_HAND
from hitab_client.recording import Recorder
from hitab_ros import EmergencySwitch, names, qos
from hitab_ros.timing import FOUND_S, HEARTBEAT_S, SETTLE_S
from hitab_studio.field.last_minute import Minute
from hitab_studio.field.markers import Markers
from hitab_studio.field.remembered_scenes import RememberedScenes
from hitab_studio.robots.topics import Options
from hitab_studio.robots.watch import Robots, RobotWatch
from hitab_studio.swarm.agent_watch import AgentWatch
from hitab_studio.swarm.attention_watch import AttentionWatch
from hitab_studio.swarm.processes import Processes
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState

STATE_CHANGES_KEPT = 60
"""State changes kept for each agent."""


@dataclass
class Connected:
    """The connection to a swarm: a node, and the clients of the agents and the world.

    Attributes:
        target: the connected swarm.
        spun: set for a moment after each spin of the node.
        asking: number of waiting coroutines.
        ended: why the connection has ended; "" while connected.
    """

    target: SwarmTarget
    link: RosLink
    agents: SwarmClient
    world: WorldClient
    spun: asyncio.Event = field(default_factory=asyncio.Event)
    asking: int = 0
    ended: str = ""

    @classmethod
    def to(
        cls,
        target: SwarmTarget,
        link: RosLink,
        read_state: Callable[[bytes], Any] | None = None,
    ) -> Connected:
        """Return the connection to a swarm over this link; see `WorldClient`."""
        space, identity = target.namespace, target.identity
        return cls(
            target,
            link,
            SwarmClient(link, target.agents, prefix=space, identity=identity),
            WorldClient(
                link,
                prefix=space,
                identity=identity,
                started_by_it=target.world,
                read_state=read_state,
            ),
        )


class Observer:
    """Collects the state of one swarm, from its connection to its end.

    Args:
        swarm: the connected swarm.
        known: the initial state.
        pages: the open pages, by id; `agent` is the viewed agent, and `connected` is true while
            a browser shows the page.
        colors: colors of states, by name, for the markers.
        complain: called with an error message and, if known, its `agent`, `page` and `error`.
        ask: sends a request to the swarm; see `SwarmLink.ask`.
        options: the chosen topics of robots.

    Attributes:
        known: the present state.
        watches: watches of the viewed agents, by name.
        minute: the last minute.
    """

    def __init__(
        self,
        swarm: Connected,
        known: SwarmState,
        pages: Mapping[str, Any],
        colors: Mapping[str, int],
        complain: Callable[..., None],
        ask: Callable[..., Awaitable[Any]],
        options: Options | None = None,
    ) -> None:
        self.known = known
        self._colors = colors
        link, agents = self._link, self._agents = swarm.link, swarm.agents
        self._world = swarm.world
        self._pages = pages
        self._complain = complain
        self._ask = ask
        target = swarm.target
        # Rebroadcasts the stop, because the process that issued it may already have exited.
        self._switch = EmergencySwitch(link.node, hands_on=True, known=known.emergency)
        self._stops = Stops(link, switch=self._switch)
        self._next_stops = 0.0
        self._signs = agents.signs_of_life(has_world=target.world)
        self._processes = Processes(target.folder)
        self._attention = AttentionWatch(agents, self._processes)
        self._remembered = RememberedScenes()
        self.minute = Minute(self._remembered)
        self.watches: dict[str, AgentWatch] = {}
        self._events: dict[str, deque[TransitionEvent]] = {}
        self._followed: dict[str, Any] = {}
        self._commanders = CommanderView(agents)
        self._reports = 0
        self._recorder: Recorder | None = None
        self._recording_page = ""
        self._markers = Markers(link)
        self._robots = RobotWatch(link, options or Options())
        self._shown: object = None

    def _know(self, **changes: Any) -> None:
        """Change the known state and raise its revision."""
        self.known = replace(self.known, revision=self.known.revision + 1, **changes)

    def see(self) -> None:
        """Take the newest state of the world."""
        state = self._world.state
        if state is None or state is self._shown:
            return
        self._shown = state
        self._signs.hear_known([names.WORLD])
        before, scene = self.known.scene, state.scene
        self.minute.see(scene, scene.cycle)
        if before is None or (before.mode, before.episode) != (scene.mode, scene.episode):
            self._know(scene=scene)
        else:
            self.known = replace(self.known, scene=scene)
        self._markers.show(scene, self.known.doing(), self._colors)

    def look(self) -> None:
        """Update the known state of the agents, the stops and the robots."""
        self._look_at_stops()
        known = self.known
        if (now := time.monotonic()) >= self._next_stops:
            self._next_stops = now + HEARTBEAT_S
            self._stops.look()
        if self._world.status is not known.world:
            self._know(world=self._world.status)
        statuses = self._agents.statuses
        heard, self._agents.news = self._agents.news, set()
        if heard:
            self._signs.hear_known(heard)
            is_new = bool(heard - known.statuses.keys())
            joined = time.monotonic() if is_new else known.joined
            self._know(statuses=MappingProxyType(dict(statuses)), joined=joined)
            for agent in heard & statuses.keys():
                at = statuses[agent].cycle if known.scene is not None else now
                self.minute.hear(agent, statuses[agent], at, len(statuses))
        if self._commanders.reports != self._reports:
            self._reports = self._commanders.reports
            self._know(groups=MappingProxyType(dict(self._commanders.groups)))
        self._listen()
        if changes := self._attention.look(self.known):
            self._know(**changes)
        wanted = {page.agent for page in self._pages.values()} - {""}
        followed = wanted if self._agents.is_large else wanted | heard
        for agent in followed & statuses.keys() - self._events.keys():
            self._follow(agent)
        for agent in wanted & statuses.keys() - self.watches.keys():
            self.watches[agent] = AgentWatch(
                self._agents,
                agent,
                self._events[agent],
                self._ask,
                partial(self._update_watched, agent),
                partial(self._complain, agent=agent),
            )
        for agent in self.watches.keys() - wanted:
            self.watches.pop(agent).close()
            if self._agents.is_large:
                self._forget_events(agent)
        for agent, watch in self.watches.items():
            watch.look()
            self._keep_scenes(agent, watch)
            if known.robots is not None and watch.read is not None:
                self.minute.hear_cycle(agent, watch.read[1], watch.read[0])
        watched = {name: watch.known for name, watch in self.watches.items()}
        if watched.keys() != known.watched.keys():
            self._know(watched=MappingProxyType(watched))
        elif any(known.watched[name] is not it for name, it in watched.items()):
            self.known = replace(self.known, watched=MappingProxyType(watched))
        if known.robots is not None:
            robots = self._robots.look(
                wanted, viewed=any(page.connected for page in self._pages.values())
            )
            if robots is not known.robots:
                if robots.scene is not None:
                    self.minute.see(robots.scene, now)
                self.known = replace(self.known, robots=robots)

    def _follow(self, agent: str) -> None:
        """Keep the state changes of an agent from now on; in a large swarm, while viewed."""
        self._events[agent] = deque(maxlen=STATE_CHANGES_KEPT)
        self._followed[agent] = self._link.subscribe(
            TransitionEvent,
            names.of_agent(agent, names.TRANSITIONS, self._agents.prefix),
            self._events[agent].append,
            qos.EVENTS,
            temporary=True,
        )

    def _forget_events(self, agent: str) -> None:
        del self._events[agent]
        self._link.node.destroy_subscription(self._followed.pop(agent))

    def _listen(self) -> None:
        """Update the silent processes and the reasons for their silence."""
        silent, before = self._signs.silent(), self.known.silent
        if silent.keys() != before.keys():
            now = time.monotonic()
            since = {name: before.get(name, now - seconds) for name, seconds in silent.items()}
            self._know(silent=MappingProxyType(since))
        why = self._processes.why({*silent, *self.known.unheard})
        if why != self.known.why:
            self._know(why=MappingProxyType(dict(why)))

    def _update_watched(self, agent: str) -> None:
        # At once, because in a paused world the next placement has the same cycle.
        self._keep_scenes(agent, self.watches[agent])
        watched = {name: watch.known for name, watch in self.watches.items()}
        self._know(watched=MappingProxyType(watched))

    def _keep_scenes(self, agent: str, watch: AgentWatch) -> None:
        training = watch.training
        if training is not None:
            self._remembered.keep(
                agent, training.name, [(e.number, e.cycle) for e in training.examples]
            )
            if self._remembered.kept is not self.known.moments:
                self._know(moments=self._remembered.kept)

    def may_show(self, choices: tuple[SwarmTarget, ...]) -> None:
        """Update the swarms that a person may choose."""
        target = self.known.target
        if target is not None and choices != target.choices:
            self._know(target=replace(target, choices=choices))

    def discover(self) -> None:
        """Find agents that have joined or left."""
        self._agents.discover()
        self._signs.set_gone(self._agents.gone())
        self._update_elsewhere()
        self._find_robots()
        self._commanders.discover()
        self._markers.look(self.known.scene, self.known.doing(), self._colors)
        if self._recorder is not None:
            self._recorder.look()
            self._know(recorded=self._recorder.bag.count)
            if self._recorder.problem:
                self._complain(self._recorder.problem, page=self._recording_page)
                self.stop_recording()

    def _find_robots(self) -> None:
        """Find the sensors of the robots, if the agents are in no simulated world."""
        known = self.known
        target = known.target
        if known.world is None and known.scene is None and not (target and target.world):
            waited = time.monotonic() > known.joined + SETTLE_S
            if known.robots is None and known.statuses and waited:
                self._know(robots=Robots())
            if known.statuses:
                self._robots.find(known.statuses, self._agents.prefix)
        elif known.robots is not None:
            self._robots.close()
            self._know(robots=None)

    def _update_elsewhere(self) -> None:
        """Update the swarms that were started elsewhere, and hide their world."""
        known = self.known
        if self._world.strangers and known.scene is not None:
            self._know(scene=None)
        if known.target is not None and known.target.identity == STARTED_BY_HAND:
            heard = {*self._agents.strangers.values(), *self._world.strangers.values()} - {""}
            if (elsewhere := tuple(sorted(heard))) != known.elsewhere:
                self._know(elsewhere=elsewhere)

    def stop_robots(self, engaged: bool, by: str, reason: str) -> list[str]:
        """Stop or release all robots and worlds; return the names of those present."""
        self._switch.set(engaged, by, reason)
        self._look_at_stops()
        return self._stops.names()

    def _look_at_stops(self) -> None:
        known, stops = self.known, self._switch.known
        if stops is not known.emergency:
            at = known.stopped_at if known.emergency else time.time()
            self._know(emergency=stops, stopped_at=at)

    async def arm(self, agent: str) -> None:
        """Re-arm an agent's robot.

        Raises:
            SwarmError: if the robot is missing or refuses.
        """
        robot = f"{self._agents.prefix}/{agent}".strip("/")
        await self._ask(lambda _: self._stops.arm.coroutine(robot, FOUND_S), agent)

    # -- recording --------------------------------------------------------------------------

    def start_recording(self, path: str, page: str = "") -> None:
        """Record all messages from now on.

        Raises:
            SwarmError: if a recording is running, or the file cannot be written.
        """
        if self._recorder is not None:
            raise SwarmError(f"already recording to {self._recorder.bag.path}")
        self._recorder = Recorder(self._link, path)
        self._recording_page = page
        self._know(recording=path, recorded=0)

    def stop_recording(self) -> str:
        """End the recording and return its path; "" if nothing was being recorded.

        Raises:
            SwarmError: if the end of the file could not be written.
        """
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return ""
        self._know(recording="")
        recorder.close()
        return str(recorder.bag.path)
