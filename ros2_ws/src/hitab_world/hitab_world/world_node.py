"""The node that owns time: it puts a simulated world on topics and services."""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable, Sequence

from hitab_msgs import msg
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from hitab_core.errors import HitabError
from hitab_ros import names, qos
from hitab_ros.conversions import time_of
from hitab_ros.guarded_node import GuardedNode
from hitab_ros.name_guard import refuse_second_of_name
from hitab_ros.spinning import Loop, Spinner
from hitab_world.attendance import Attendance
from hitab_world.audience import Audience
from hitab_world.settings import WorldSettings
from hitab_world.world import LOOK, RESTART, LiveWorld, World
from hitab_world.world_keeper import WorldKeeper
from hitab_world.world_services import WorldServices

NANOSECONDS = 1_000_000_000
STATUS_PERIOD_NS = NANOSECONDS
FAULTS_PERIOD_NS = NANOSECONDS // 20  # until a fault that has come or gone is published
LOOK_FOR_VIEWERS_EVERY = 50  # cycles
LISTENER_S = 10.0  # to wait for whoever listened to the episodes before a restart
NAMED_MAX = 10  # agents that an error names
TURN, STEP, REFUSED, LATE, WAITING = "turn", "step", "refused", "late", "waiting"  # faults
UNREAD_MAX = 100  # events that are handled after a deadline to find answers among them


class WorldNode(GuardedNode):
    """A world in the namespace of its name.

    `run` is the process's main loop: a cycle sends a percept to each agent, waits for their
    answers (lockstep) or for the time to pass (real time), and advances the world. While paused
    the agents are shown the world at each change, so that what a demonstrator then commands is
    recorded with what can be seen.
    """

    def __init__(self, make_world: Callable[[Node, int], World]) -> None:
        """Make the node and its world.

        Args:
            make_world: given this node, to declare parameters on, and the seed.

        Raises:
            HitabError: if a parameter is not usable.
        """
        super().__init__("world")
        self.settings = settings = WorldSettings.declare(self)
        self.world = make_world(self, settings.seed)
        self._live_world = self.world if isinstance(self.world, LiveWorld) else None
        self.pace = settings.pace
        self.factor = settings.factor
        self.paused = settings.paused
        self.steps_left = 0
        self.episodes_left = 0
        self.disturbed = True
        self._in_real_time = False
        # The time of day, so that the rounds of a world that is started again are new ones.
        self._sequence = time.time_ns()
        self._restart = True
        self._note = ""
        self._error = ""
        self._next_cycle_ns = 0
        self._next_state_ns = 0
        self._next_status_ns = 0
        self._viewed = self._clocked = False
        self._audience = Audience(self, tuple(self.world.agents))
        self.attendance = Attendance(self.world.agents, self._audience.has)
        self.keeper = WorldKeeper(self)
        self._state = self.create_publisher(msg.WorldState, names.STATE, qos.LATCHED)
        self._status = self.create_publisher(msg.WorldStatus, names.STATUS, qos.LATCHED)
        self._episodes = self.create_publisher(msg.Episode, names.EPISODES, qos.EVENTS)
        self._clock_publisher = self.create_publisher(ClockMessage, names.CLOCK, qos.STREAM)

    def join(self) -> None:
        """Begin to listen and to answer, once it is certain that the name is free."""
        self._audience.join(self.attendance.take)
        self._restored = self.keeper.restore()
        if self._restored:
            # Agents that live on do not begin anew, and what came after the snapshot comes again.
            self._restart = False
            self._in_real_time = True
        self._world_services = WorldServices(self)

    def destroy_node(self) -> None:
        """Keep the world's state, then take the node down."""
        self.keeper.close()
        super().destroy_node()

    def look_who_is_there(self) -> bool:
        """Find out which agents have joined the world; return whether that has changed."""
        self._audience.look()
        return self.attendance.look()

    # -- the main loop ----------------------------------------------------------------------

    def run(self, spinning: Spinner) -> int:
        """Run the world until the spinner is stopped; return the exit code."""
        if self._restored and self.episodes_left:
            # Who has asked for them still listens, and has to find this process first.
            spinning.spin_until(lambda: self._episodes.get_subscription_count() > 0, LISTENER_S)
        while not spinning.stopped:
            if not self.guard.run(TURN, self._turn, spinning):
                self._pause(TURN)
                spinning.spin_once(timeout_sec=0.1)
        return spinning.exit_code

    def _turn(self, spinning: Spinner) -> None:
        """Do what is to be done now: wait, show the world, or play a cycle."""
        self._attend()
        self.keeper.attend()
        if not self._live():
            spinning.spin_once(timeout_sec=0.01)
        elif self.paused and not self.steps_left:
            if self.disturbed:
                self._show(spinning)
            spinning.spin_once(timeout_sec=0.1)
        elif self.pace == msg.WorldStatus.LOCKSTEP and not self.attendance.present:
            spinning.spin_once(timeout_sec=0.1)  # nobody to play with yet
        else:
            self._cycle(spinning)

    def _pause(self, fault: str) -> None:
        """Stand still after an error in the world itself, until a person resumes it."""
        self.paused = True
        self.steps_left = 0
        self.report_error(f"paused: {self.guard.faults.text(fault)}")

    def _live(self) -> bool:
        """Keep a world that goes on by itself company; return whether it can be stepped."""
        world = self._live_world
        if world is None:
            return True
        alone = self.pace == msg.WorldStatus.LOCKSTEP and not self.attendance.present
        if world.waiting or alone or (self.paused and not self.steps_left):
            happened = world.idle()
            if happened == RESTART:
                self.mark_restart()
            elif happened == LOOK:
                self.disturbed = True
        if world.waiting:
            self.guard.log(world.waiting)
        self.guard.faults.set(WAITING, world.waiting)
        return not world.waiting

    def _attend(self) -> None:
        now = time.monotonic_ns()
        if now >= self._next_status_ns:
            self._next_status_ns = now + STATUS_PERIOD_NS
            changed = self.look_who_is_there()
            if changed or (self.attendance.silent and self.paused):
                self.disturbed = True  # shown again, so that who was late may answer
            self.publish_status()

    def _show(self, spinning: Spinner) -> None:
        """Have the agents perceive the world as it stands, without acting."""
        self.disturbed = False
        self._send_percepts(look=True)
        self._wait(spinning, time.monotonic_ns() + int(self.settings.deadline * NANOSECONDS))
        self.attendance.give_up_on_late()
        if self.disturbed:
            return
        self._publish_state()
        self.publish_status()

    def _cycle(self, spinning: Spinner) -> None:
        self.disturbed = False
        lockstep = self.pace == msg.WorldStatus.LOCKSTEP
        self._in_real_time |= not lockstep
        self._send_percepts(look=False)
        now = time.monotonic_ns()
        if lockstep:
            deadline = now + int(self.settings.deadline * NANOSECONDS)
        else:
            period = int(self.world.cycle_seconds / self.factor * NANOSECONDS)
            # After a pause or a hold-up the world goes on from now instead of catching up.
            behind = now - self._next_cycle_ns > 5 * period
            deadline = self._next_cycle_ns = (now if behind else self._next_cycle_ns) + period
        self._wait(spinning, deadline, whole=not lockstep)
        if self.disturbed or spinning.stopped:
            return  # what they answered was about another situation
        late = ""
        if not self.attendance.complete:
            names_of_late = self.attendance.count_late(exclude=lockstep)
            late = f"no answer in time from {_some(names_of_late)}"
            self.guard.log(f"{late} in cycle {self.world.cycle}", late)
        if late or not self.attendance.silent:
            self.guard.faults.set(LATE, late)
        self._advance()

    def _wait(self, spinning: Spinner, deadline_ns: int, *, whole: bool = False) -> None:
        """Handle events until all have answered, or, with ``whole``, until the deadline."""
        attendance = self.attendance
        spin_once = spinning.spin_once
        while not self.disturbed and not spinning.stopped:
            if not whole and attendance.complete:
                return
            left = deadline_ns - time.monotonic_ns()
            if left <= 0:
                break
            spin_once(timeout_sec=min(left / NANOSECONDS, 0.1))

        # Where this process itself was held up, answers that came in time are still unread.
        for _ in range(UNREAD_MAX):
            if attendance.complete or self.disturbed or spinning.stopped:
                return
            spin_once(timeout_sec=0.0)

    def _send_percepts(self, *, look: bool) -> None:
        world = self.world
        self._sequence += 1
        self.attendance.begin(self._sequence)
        common = {
            "stamp": time_of(world.cycle * world.cycle_seconds),
            "sequence": self._sequence,
            "cycle": world.cycle,
            "episode": world.episode,
            "seed": world.seed,
            "look": look,
            "lockstep": self.pace == msg.WorldStatus.LOCKSTEP,
            "restart": self._restart,
        }
        self._audience.send(common, self._percept)
        self._restart = False

    def _percept(self, agent: str) -> tuple[Sequence[float], Sequence[str]] | None:
        """Return what an agent perceives; None if the world cannot say it, which is a fault."""
        key = f"percept of {agent}"
        try:
            values, heard = self.world.percept(agent)
            sensed = array("d", values), heard
        except Exception as error:
            self.guard.failed(key, error)
            self.attendance.excuse(agent)
            return None
        if key in self.guard.faults:
            self.guard.faults.clear(key)
        return sensed

    def _advance(self) -> None:
        world = self.world
        try:
            ended = world.step(self.attendance.answers)
        except Exception as error:
            self.guard.failed(STEP, error)
            self._pause(STEP)
            return
        self.guard.faults.clear(STEP)
        refused = _some(list(world.refused.values()), "; ")
        if refused:
            self.guard.log(refused)
        self.guard.faults.set(REFUSED, refused)
        if self._clocked:
            self._clock_publisher.publish(
                ClockMessage(clock=time_of(world.cycle * world.cycle_seconds))
            )
        if self.steps_left:
            self.steps_left -= 1
        if ended is not None:
            self._end_episode(ended)
        if world.cycle % LOOK_FOR_VIEWERS_EVERY == 0:
            self._look_for_viewers()
        if self.paused and not self.steps_left:
            self.disturbed = True  # to be shown
        elif self._viewed:
            now = time.monotonic_ns()
            if now >= self._next_state_ns or ended is not None:
                self._next_state_ns = now + int(NANOSECONDS / self.settings.state_rate)
                self._publish_state()

    def _look_for_viewers(self) -> None:
        self._viewed = self._state.get_subscription_count() > 0
        self._clocked = self._clock_publisher.get_subscription_count() > 0

    # -- episodes ---------------------------------------------------------------------------

    def begin_run(self, seed: int) -> None:
        """Begin the first episode of a run, and to count what would make it another one."""
        self.attendance.missed_deadlines = 0
        self._in_real_time = False
        self.begin_episode(0, seed)

    @property
    def reproducible(self) -> bool:
        """Whether the same seed gives this run again: nobody was late, and no clock took part."""
        return not (self._in_real_time or self.attendance.missed_deadlines)

    def _end_episode(self, ended: str) -> None:
        result = self.world.result()
        self._episodes.publish(
            msg.Episode(
                number=result.number,
                seed=result.seed,
                cycles=result.cycles,
                seconds=result.seconds,
                ended=result.ended,
                reproducible=self.reproducible,
                measure_names=list(result.measures),
                measures=[float(value) for value in result.measures.values()],
            )
        )
        self._note = ended
        if self.episodes_left:
            self.episodes_left -= 1
            if not self.episodes_left:
                self.paused = True
                self.steps_left = 0
        self.begin_episode()

    def begin_episode(self, number: int | None = None, seed: int | None = None) -> None:
        """Begin the next episode, or the given one; agents begin at Start."""
        self.world.reset(number, seed)
        self.mark_restart()
        self.keeper.touch()

    def mark_restart(self) -> None:
        """Have the agents begin at Start with the next percept."""
        self._restart = True
        self.disturbed = True

    # -- telling ----------------------------------------------------------------------------

    def report_error(self, text: str) -> None:
        """Publish the status with what was refused last, at most once for the same text."""
        if text != self._error:
            self._error = text
            if text:
                self.guard.log(text)
            self.publish_status()

    def faults_changed(self) -> None:
        """Publish the status soon, at the next turn."""
        self._next_status_ns = min(self._next_status_ns, time.monotonic_ns() + FAULTS_PERIOD_NS)

    def publish_status(self) -> None:
        """Publish how the world runs."""
        world = self.world
        faults = self.guard.faults.texts()
        self._status.publish(
            msg.WorldStatus(
                stamp=time_of(world.cycle * world.cycle_seconds),
                world=world.name,
                mode=self._mode(),
                pace=self.pace,
                factor=self.factor,
                cycle=world.cycle,
                episode=world.episode,
                seed=world.seed,
                missed_deadlines=self.attendance.missed_deadlines,
                reproducible=self.reproducible,
                agents=list(world.agents),
                missing=self.attendance.missing,
                episodes_left=self.episodes_left,
                last_error=self._error or (faults[0] if faults else ""),
                faults=faults,
                swarm=self.settings.swarm,
            )
        )

    def _mode(self) -> str:
        paused = self.paused and not self.steps_left
        return msg.WorldState.PAUSED if paused else msg.WorldState.RUNNING

    def _publish_state(self) -> None:
        world = self.world
        entities = self.guard.wrap("the state for viewers", self._entities, otherwise=[])()
        self._state.publish(
            msg.WorldState(
                stamp=time_of(world.cycle * world.cycle_seconds),
                world=world.name,
                mode=self._mode(),
                cycle=world.cycle,
                episode=world.episode,
                episode_cycle=world.episode_cycle,
                width=float(world.size[0]),
                height=float(world.size[1]),
                entities=entities,
                note=self._note,
            )
        )
        self._note = ""

    def _entities(self) -> list[msg.Entity]:
        fields = ("name", "kind", "x", "y", "heading", "vx", "vy", "radius", "say")
        return [
            msg.Entity(**{field: getattr(entity, field) for field in fields})
            for entity in self.world.entities()
        ]


def _some(agents: list[str], between: str = ", ") -> str:
    """Name some agents, and say how many there are besides."""
    more = len(agents) - NAMED_MAX
    return between.join(agents[:NAMED_MAX]) + (f" and {more} more" if more > 0 else "")


def run_world(make_world: Callable[[Node, int], World], spinning: Spinner) -> Loop:
    """Make the node of a world and return the loop that runs it.

    Raises:
        HitabError: if a parameter is not usable, or such a world runs already.
    """
    node = WorldNode(make_world)
    spinning.executor.add_node(node)
    refuse_second_of_name(spinning, [node], msg.WorldStatus)
    node.join()
    if not node.world.agents:
        raise HitabError("a world without agents cannot be run")
    return node.run
