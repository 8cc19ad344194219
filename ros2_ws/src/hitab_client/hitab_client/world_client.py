"""Client of a world, through its public topics and services."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from hitab_msgs.msg import Entity, Episode, WorldState, WorldStatus
from hitab_msgs.srv import Control, Place, Play, Snapshot

from hitab_client.connecting.identity import is_own
from hitab_client.connecting.ros_link import RosLink
from hitab_client.errors import SwarmError
from hitab_client.rest import Rest
from hitab_client.runs.run_processes import RunProcesses
from hitab_client.showing.swarm_listener import SwarmListener
from hitab_core import Fix, some
from hitab_ros import names, qos
from hitab_ros.call import blocking
from hitab_ros.messages.stamps import seconds_of
from hitab_ros.timing import FOUND_S, PROMPT_S, REPEAT_S, SETTLE_S

NO_WORLD = "no world answers; is a swarm with a world up?"
NOT_SIMULATED = (
    "this swarm has no world: its swarm file names none, and none that was started by hand "
    "answers; only a world can be driven"
)
MODE_AFTER_REQUEST = {
    Control.Request.PAUSE: WorldState.PAUSED,
    Control.Request.RESUME: WorldState.RUNNING,
}
NAN = float("nan")
THE_WORLD = "the world"


class WorldClient(SwarmListener):
    """Client of a swarm's world over ROS.

    Args:
        link: the node to use.
        prefix: namespace of the swarm.
        identity: the swarm's identity; empty for any swarm.
        started_by_it: whether the swarm has started a world.
        processes: the swarm's processes, which show why the world does not answer.
        read_state: returns a checked state, or an object with the fields that are needed, from
            its bytes; None for a `WorldState`.

    Attributes:
        status: the last status of the swarm's world.
        speed: recent speed, simulated seconds per second.
    """

    def __init__(
        self,
        link: RosLink,
        *,
        prefix: str = "",
        identity: str = "",
        started_by_it: bool = True,
        processes: RunProcesses | None = None,
        read_state: Callable[[bytes], Any] | None = None,
    ) -> None:
        super().__init__(link, prefix, identity, (THE_WORLD,) if started_by_it else ())
        self._processes = processes or RunProcesses()
        self.status: WorldStatus | None = None
        self.state: WorldState | None = None
        self.speed = 1.0
        self._first_stamp: tuple[float, float] | None = None
        self.episodes: list[Episode] = []
        link.subscribe(WorldStatus, self._name(names.STATUS), self._take_status, qos.LATCHED)
        link.subscribe(
            WorldState,
            self._name(names.STATE),
            self._take_state,
            qos.LATCHED,
            read=read_state,
            checked=read_state is None,
        )
        link.subscribe(Episode, self._name(names.EPISODES), self.episodes.append, qos.EVENTS)

    def _name(self, name: str) -> str:
        return names.of_world(name, self.prefix)

    def _take_status(self, status: WorldStatus) -> None:
        if self._is_own(THE_WORLD, status.swarm):
            self.status = status

    def _take_state(self, state: WorldState) -> None:
        started_by_it = THE_WORLD in self._started
        if not is_own(state.swarm, self.identity, started_by_it=started_by_it):
            return
        self.state = state
        now, simulated = time.monotonic(), seconds_of(state.header.stamp)
        if self._first_stamp is None or simulated < self._first_stamp[1]:
            self._first_stamp = now, simulated
        elif now > self._first_stamp[0]:
            self.speed = (simulated - self._first_stamp[1]) / (now - self._first_stamp[0])
            if now - self._first_stamp[0] > REPEAT_S:
                self._first_stamp = now, simulated

    @blocking
    async def wait(self, seconds: float = 8.0) -> WorldStatus:
        """Wait for the world and return its status.

        Raises:
            SwarmError: if there is no world (with the reason, if known), or only another swarm's.
        """
        own = names.WORLD in self._processes
        if self._processes.are_known and not own:
            seconds = min(seconds, PROMPT_S)
        is_lost, began = self._processes.is_lost, time.monotonic()

        def is_decided() -> bool:
            # A world that another process runs is heard by then.
            settled = time.monotonic() > began + SETTLE_S
            return bool(self.status or self.strangers) or (settled and is_lost(names.WORLD))

        await self.link.until(
            is_decided,
            seconds,
            waiting_for=lambda: THE_WORLD,
        )
        self.refuse_strangers(self.strangers)
        if self.status is None:
            late = f"the world has been silent for {seconds:g} s"
            silent = SwarmError(late, Fix.LOGS(node=names.WORLD))
            raise self._processes.reason(names.WORLD) or (silent if own else self._absent)
        return self.status

    @property
    def _absent(self) -> SwarmError:
        """Error for a missing world, with the way out; a swarm of robots needs none."""
        if self._processes.are_known:
            return SwarmError(NOT_SIMULATED)
        return SwarmError(NO_WORLD, Fix.UP(swarm="keepaway"))

    def is_there(self) -> bool:
        """Whether a world has been discovered."""
        return bool(self.link.node.count_publishers(self._name(names.STATUS)))

    @blocking
    async def ask(self, kind: Any, service: str, **fields: Any) -> Any:
        """Call one of the world's services and return its answer.

        Raises:
            SwarmError: if the world refuses, with its message, or belongs to another swarm.
        """
        await self.wait.coroutine()
        return await self.link.call.coroutine(
            kind,
            self._name(service),
            kind.Request(**fields),
            missing=lambda: self._processes.reason(names.WORLD) or self._absent,
            where="the world refuses",
        )

    @blocking
    async def control(
        self, action: str, *, cycles: int = 0, pace: str = "", factor: float = 0.0, to: int = 0
    ) -> Any:
        """Pause, resume, step, reset or put back the world, or set its pace.

        Args:
            action: see `Control`.
            cycles: number of cycles to step.
            pace: lockstep or realtime; empty to keep it.
            factor: speed in real-time pace, or with the action ``teaching`` the further factor
                while an agent is taught; 0 to keep it.
            to: cycle to go back to.
        """
        answer = await self.ask.coroutine(
            Control, names.CONTROL, action=action, cycles=cycles, pace=pace, factor=factor, to=to
        )
        mode = MODE_AFTER_REQUEST.get(action, "")
        field = "teaching" if action == Control.Request.TEACHING else "factor"
        await self._await_status(
            lambda status: (
                mode in ("", status.mode)
                and pace in ("", status.pace)
                and factor in (0.0, getattr(status, field))
            )
        )
        return answer

    @blocking
    async def go_back(self, *, to: int = 0, seconds: float = 0.0) -> WorldState:
        """Put the world back to a cycle, and return its state once the agents have perceived it.

        Args:
            to: the cycle; 0 to go back by ``seconds``.
            seconds: simulated time from now, s.

        Raises:
            SwarmError: if the world cannot go back there; it runs as before then.
        """
        before = await self.wait.coroutine()
        runs = before.mode == WorldState.RUNNING
        requests = Control.Request
        if not to and before.oldest:  # else it refuses, whatever the cycle
            now = await self.shown.coroutine(await self.control.coroutine(requests.PAUSE))
            cycles_per_second = now.cycle / seconds_of(now.header.stamp)
            to = max(0, round(now.cycle - seconds * cycles_per_second))  # 0 is refused
        try:
            answer = await self.control.coroutine(requests.BACK, to=to)
        except SwarmError:
            if runs:
                await self.control.coroutine(requests.RESUME)
            raise
        state = await self.shown.coroutine(answer)
        await self._await_status(lambda status: status.cycle <= to)
        return state

    async def _await_status(self, right: Callable[[WorldStatus], bool]) -> None:
        """Wait for the status that was sent before an answer or a state, on another topic.

        Until it arrives, a command would rely on the world's former status.
        """
        await self.link.until(lambda: self.status is None or right(self.status), FOUND_S)

    @property
    def is_paused(self) -> bool:
        """Whether the world is paused, according to its last status."""
        return self.status is not None and bool(self.status.mode == WorldState.PAUSED)

    @property
    def missing(self) -> list[str]:
        """The agents without which the world continues, according to its last status."""
        return list(self.status.missing) if self.status is not None else []

    @blocking
    async def step(
        self,
        cycles: int = 1,
        seconds: float = 30.0,
        left: Callable[[int], None] = lambda cycles: None,
    ) -> WorldState:
        """Run a paused world for some cycles and return its state.

        Args:
            cycles: number of cycles.
            seconds: timeout for each cycle.
            left: called before each cycle with the number of remaining cycles.

        Raises:
            SwarmError: if a cycle takes longer.
        """
        last = (await self.control.coroutine(Control.Request.STEP, cycles=cycles)).cycle
        rest = Rest(lambda: self.status)

        def rests() -> bool:
            """Raise if the world rests too early."""
            if (status := rest.look()) and status.cycle < last:
                raise rest.error(f"the world did not reach cycle {last}")
            return False

        state = await self.state_at.coroutine(0, seconds)
        while state.cycle < last:
            left(last - state.cycle)
            state = await self.state_at.coroutine(state.cycle + 1, seconds, rests)
        await self._await_status(lambda status: status.cycle >= last)
        return state

    @blocking
    async def state_at(
        self, cycle: int, seconds: float = 10.0, rests: Callable[[], bool] = lambda: False
    ) -> WorldState:
        """Wait for the state of a cycle, or of a later one.

        Args:
            cycle: number of the cycle.
            seconds: timeout.
            rests: raises if the state will not arrive.

        Raises:
            SwarmError: if the state does not arrive in time.
        """
        what = f"reach cycle {cycle}"
        return await self._awaited(lambda state: state.cycle >= cycle or rests(), what, seconds)

    async def _awaited(
        self, right: Callable[[WorldState], bool], what: str, seconds: float
    ) -> WorldState:
        if not await self.link.until(
            lambda: self.state is not None and right(self.state),
            seconds,
            waiting_for=lambda: some(self.missing) or THE_WORLD,
        ):
            late = f"the world did not {what} within {seconds:g} s"
            raise self._processes.reason(names.WORLD) or SwarmError(
                late, Fix.LOGS(node=names.WORLD)
            )
        assert self.state is not None
        return self.state

    @blocking
    async def shown(self, answer: Any, seconds: float = 10.0) -> WorldState:
        """Return the state of a paused world once the agents have perceived a change.

        Args:
            answer: answer of the service that changed the world.
            seconds: timeout.

        Raises:
            SwarmError: if the world does not publish its state.
        """
        return await self._awaited(lambda state: state.change >= answer.change, "show it", seconds)

    @blocking
    async def place(
        self, things: Mapping[str, Mapping[str, float]], *, new_episode: bool = False
    ) -> Any:
        """Place things.

        Args:
            things: coordinates by name: any of x, y, heading, vx and vy. Others are kept.
            new_episode: whether to begin a new episode from these positions.
        """
        entities = [
            Entity(
                name=name,
                **{key: float(place.get(key, NAN)) for key in ("x", "y", "heading", "vx", "vy")},
            )
            for name, place in things.items()
        ]
        return await self.ask.coroutine(
            Place, names.PLACE, entities=entities, new_episode=new_episode
        )

    @blocking
    async def snapshot(self, action: str, name: str = "") -> Any:
        """Save, restore, delete or list snapshots."""
        return await self.ask.coroutine(Snapshot, names.SNAPSHOT, action=action, name=name)

    @blocking
    async def play(
        self,
        episodes: int,
        seed: int,
        *,
        progress: Callable[[int], None] | None = None,
        stall_seconds: float = 60.0,
    ) -> list[Episode]:
        """Play episodes and return their results.

        Raises:
            SwarmError: if no cycle is played for ``stall_seconds``, or if a breakpoint is met.
        """
        await self.link.until(
            lambda: self.link.node.count_publishers(self._name(names.EPISODES)) > 0, 5.0, 0.01
        )
        run = (await self.ask.coroutine(Play, names.PLAY, episodes=episodes, seed=seed)).run
        rest = Rest(lambda: self.status)

        def played() -> list[Episode]:
            """Return the run's episodes as first reported; a restarted world repeats some."""
            by_number: dict[int, Episode] = {}
            for episode in self.episodes:
                if episode.run == run:
                    by_number.setdefault(episode.number, episode)
            return list(by_number.values())

        while (seen := len(played())) < episodes:
            if progress is not None:
                progress(seen)
            cycle = self._cycle

            def ended(known: int = len(self.episodes), seen: int = seen) -> bool:
                if (status := rest.look()) and status.held and len(self.episodes) == known:
                    raise rest.error(f"the world has played {seen} of {episodes} episodes")
                return len(self.episodes) > known

            # In real time, a long episode is not a stall either.
            if not await self.link.until(ended, stall_seconds) and self._cycle == cycle:
                raise SwarmError(
                    f"no cycle was played for {stall_seconds:g} s after {seen} of {episodes} "
                    f"episodes{self._why_stalled()}"
                )
        return played()

    @property
    def _cycle(self) -> int:
        return -1 if self.status is None else int(self.status.cycle)

    def _why_stalled(self) -> str:
        if self.missing:
            return f"; no node answers for {', '.join(self.missing)}"
        problem = self.status.last_error if self.status is not None else ""
        return f"; the world reports: {problem}" if problem else ""
