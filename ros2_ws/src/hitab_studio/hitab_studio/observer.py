"""Observes the connected swarm; in the link's thread."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Any, Protocol

from hitab_msgs.msg import CommanderStatus

from hitab_client import SignsOfLife, Stops, SwarmError
from hitab_client.identity import BY_HAND, is_own
from hitab_client.recording import Recorder
from hitab_ros import EmergencySwitch, names, qos
from hitab_studio.agent_watch import AgentWatch
from hitab_studio.jobs import Connected
from hitab_studio.known import Known
from hitab_studio.markers import Markers
from hitab_studio.processes import Processes
from hitab_studio.remembered_scenes import RememberedScenes
from hitab_studio.robots.topics import Options
from hitab_studio.robots.watch import Robots, RobotWatch
from hitab_studio.scene import scene_of
from hitab_studio.swarm_finder import Choice
from hitab_studio.viewing import Viewing

ARM_S = 3.0
"""How long a robot may take to be found that is to act again, s."""

SOON = 1.0
"""s; a world that is there is heard by then."""


class Complain(Protocol):
    """Shows an error: on a page, on those that view an agent, or on all."""

    def __call__(
        self, agent: str, text: str, error: Exception | None = None, session: str = ""
    ) -> None:
        """Show an error."""


class Observer:
    """What is known of one swarm, from its connection to its end.

    Args:
        swarm: the swarm to observe.
        known: what is known at first.
        viewing: what pages show at present; kept up to date by the caller.
        complain: called with errors.
        options: what a person has chosen of the robots' topics.

    Attributes:
        known: what is known now.
        colors: of states, in the markers for other viewers.
    """

    def __init__(
        self,
        swarm: Connected,
        known: Known,
        viewing: Viewing,
        complain: Complain,
        options: Options | None = None,
    ) -> None:
        self.known = known
        self.colors: Mapping[str, int] = {}
        self._swarm = swarm
        self._viewing = viewing
        self._complain = complain
        target = known.target
        # It hands on what it hears, as long as it is there: those who stop all may end at once.
        self._switch = EmergencySwitch(swarm.link.node, hands_on=True)
        if known.emergency is not None:
            self._switch.take(known.emergency)
        self._stops = Stops(swarm.link, switch=self._switch)
        self._signs = SignsOfLife(
            swarm.link,
            (*target.agents, *([names.WORLD] if target.world else [])) if target else (),
            identity=target.identity if target else "",
        )
        self._processes = Processes(target.folder if target else "")
        self._remembered = RememberedScenes()
        self._watches: dict[str, AgentWatch] = {}
        self._group_topics: set[str] = set()
        self._recorder: Recorder | None = None
        self._recording_page = ""
        self._markers = Markers(swarm.link)
        self._robots = RobotWatch(swarm.link, options or Options())
        self._shown: object = None

    def _know(self, **changes: Any) -> None:
        """Update what is known and shown by pages."""
        self.known = replace(self.known, revision=self.known.revision + 1, **changes)

    def see(self) -> None:
        """Take the newest moment of the world."""
        state = self._swarm.world.state
        if state is None or state is self._shown or self._swarm.world.stranger is not None:
            return
        self._shown = state
        self._signs.take_signs_of([names.WORLD])
        before, scene = self.known.scene, scene_of(state)
        self._remembered.see(scene)
        if before is None or (before.mode, before.episode) != (scene.mode, scene.episode):
            self._know(scene=scene)
        else:
            self.known = replace(self.known, scene=scene)
        self._markers.show(scene, self.known.doing(), self.colors)

    def look(self) -> None:
        """Update what has changed about the agents."""
        swarm, known = self._swarm, self.known
        if self._switch.state is not known.emergency:
            self._know(emergency=self._switch.state)
        self._stops.look()
        if swarm.world.status is not known.world:
            self._know(world=swarm.world.status)
        statuses = swarm.agents.statuses
        heard = {name for name, it in statuses.items() if known.statuses.get(name) is not it}
        if heard:
            self._signs.take_signs_of(heard)
            is_new = bool(heard - known.statuses.keys())
            joined = time.monotonic() if is_new else known.joined
            self._know(statuses=MappingProxyType(dict(statuses)), joined=joined)
        self._listen()
        wanted = {agent for agents in self._viewing.focus.values() for agent in agents}
        for agent in wanted & statuses.keys() - self._watches.keys():
            self._watches[agent] = AgentWatch(
                swarm.link,
                agent,
                partial(statuses.get, agent),
                partial(self._learns, agent),
                partial(self._complain, agent),
                swarm.agents.prefix,
            )
        for agent in self._watches.keys() - wanted:
            self._watches.pop(agent).close()
        for agent, watch in self._watches.items():
            watch.look()
            self._keep_scenes(agent, watch)
        watched = {name: watch.known for name, watch in self._watches.items()}
        if watched.keys() != known.watched.keys():
            self._know(watched=MappingProxyType(watched))
        elif any(known.watched[name] is not it for name, it in watched.items()):
            self.known = replace(self.known, watched=MappingProxyType(watched))
        if known.robots is not None:
            robots = self._robots.look(wanted, viewed=bool(self._viewing.pages))
            if robots is not known.robots:
                self.known = replace(self.known, robots=robots)

    def _listen(self) -> None:
        """Notice who falls silent and who is heard again."""
        silent, before = self._signs.silent(), self.known.silent
        if silent.keys() != before.keys():
            now = time.monotonic()
            since = {name: before.get(name, now - seconds) for name, seconds in silent.items()}
            self._know(silent=MappingProxyType(since))
        why = self._processes.why({*silent, *self.known.gone, *self.known.unheard})
        if why != self.known.why:
            self._know(why=MappingProxyType(dict(why)))

    def _learns(self, agent: str) -> None:
        # At once: in a paused world the next placement is a moment of the same cycle.
        self.with_watch(agent, partial(self._keep_scenes, agent))
        watched = {name: watch.known for name, watch in self._watches.items()}
        self._know(watched=MappingProxyType(watched))

    def _keep_scenes(self, agent: str, watch: AgentWatch) -> None:
        training = watch.known.training
        if training is not None:
            self._remembered.keep(
                agent, training.name, [(e.number, e.cycle) for e in training.examples]
            )
            if self._remembered.kept is not self.known.moments:
                self._know(moments=self._remembered.kept)

    def with_watch(self, agent: str, do: Callable[[AgentWatch], None]) -> None:
        """Do something with the watcher of an agent, if there is one."""
        if (watch := self._watches.get(agent)) is not None:
            do(watch)

    def may_show(self, choices: tuple[Choice, ...]) -> None:
        """Know which swarms a person may choose."""
        target = self.known.target
        if target is not None and choices != target.choices:
            self._know(target=replace(target, choices=choices))

    def keep_house(self) -> None:
        """Find agents that have joined or left."""
        swarm = self._swarm
        node = swarm.link.node
        swarm.agents.discover()
        before, now = self.known.gone, time.monotonic()
        gone = {
            name: before.get(name, now)
            for name in swarm.agents.statuses
            if node.count_publishers(names.of_agent(name, names.STATUS, swarm.agents.prefix)) == 0
        }
        if gone != before:
            self._know(gone=MappingProxyType(gone))
        self._leave_alone()
        self._find_robots()
        for topic in swarm.link.topics_of_type("hitab_msgs/msg/CommanderStatus"):
            if topic not in self._group_topics:
                self._group_topics.add(topic)
                swarm.link.subscribe(CommanderStatus, topic, self._take_group, qos.LATCHED)
        self._markers.look(self.known.scene, self.known.doing(), self.colors)
        if self._recorder is not None:
            self._recorder.look()
            self._know(recorded=self._recorder.count)
            if self._recorder.problem:
                self._complain("", self._recorder.problem, session=self._recording_page)
                self.stop_recording()

    def _find_robots(self) -> None:
        """Find the sensors of the robots, if there is no world in which the agents are."""
        known = self.known
        target = known.target
        if known.world is None and known.scene is None and not (target and target.world):
            if known.robots is None and known.statuses and time.monotonic() > known.joined + SOON:
                self._know(robots=Robots())
            if known.statuses:
                self._robots.find(known.statuses, self._swarm.agents.prefix)
        elif known.robots is not None:
            self._robots.close()
            self._know(robots=None)

    def _leave_alone(self) -> None:
        """Notice swarms that were started elsewhere, and show nothing of their world."""
        swarm, known = self._swarm, self.known
        if swarm.world.stranger is not None and known.scene is not None:
            self._know(scene=None)
        if known.target is not None and known.target.identity == BY_HAND:
            heard = {*swarm.agents.strangers.values(), swarm.world.stranger or ""} - {""}
            if (elsewhere := tuple(sorted(heard))) != known.elsewhere:
                self._know(elsewhere=elsewhere)

    def _take_group(self, status: CommanderStatus) -> None:
        target = self.known.target
        if target is None or not is_own(status.swarm, target.identity, started_by_it=False):
            return
        self._know(groups=MappingProxyType({**self.known.groups, status.commander: status}))

    def stop_robots(self, engaged: bool, by: str, reason: str) -> list[str]:
        """Stop all robots and worlds, or release them; return who is there."""
        self._know(emergency=self._switch.set(engaged, by, reason))
        return self._stops.names()

    def arm(self, agent: str) -> None:
        """Let an agent's robot act again.

        Raises:
            SwarmError: if it may not.
        """
        self._stops.arm(f"{self._swarm.agents.prefix}/{agent}".strip("/"), ARM_S)

    # -- recording; to be called as jobs ----------------------------------------------------

    def start_recording(self, path: str, session: str = "") -> None:
        """Record all messages from now on.

        Raises:
            SwarmError: if a recording is running, or the file cannot be written.
        """
        if self._recorder is not None:
            raise SwarmError(f"already recording to {self._recorder.path}")
        self._recorder = Recorder(self._swarm.link, path)
        self._recording_page = session
        self._know(recording=path, recorded=0)

    def stop_recording(self) -> str:
        """End the recording and return its path; "" if there was none.

        Raises:
            SwarmError: if its end could not be written.
        """
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return ""
        self._know(recording="")
        recorder.close()
        return str(recorder.path)
