"""The node of a simulated world, which owns time and offers the world on topics and services."""

from __future__ import annotations

import sys
import time
from array import array
from collections.abc import Callable, Sequence
from functools import partial
from typing import NoReturn

from hitab_msgs import msg
from rclpy.node import Node

from hitab_core import Fix, HitabError, some
from hitab_ros import (
    EmergencySwitch,
    GuardedNode,
    KnownStops,
    Loop,
    Spinner,
    StopState,
    check_name_is_free,
    give_signs_of_life,
    names,
    qos,
    run,
    steady_timer,
    stop_report,
)
from hitab_ros.messages.stamps import NANOSECONDS, time_of
from hitab_ros.nodes.diagnostics import Diagnosis, Diagnostics
from hitab_ros.nodes.fault_texts import STOPPED
from hitab_ros.stopping.emergency_stop import stopped_by
from hitab_ros.timing import ANSWER_S, AT_ONCE_S, HEARTBEAT_S
from hitab_world.node.diagnosis import diagnosis_of_world
from hitab_world.node.host_registry import SwarmSettings
from hitab_world.node.percept_sender import PerceptSender
from hitab_world.node.settings import WorldSettings
from hitab_world.node.world_services import WorldServices
from hitab_world.node.world_topics import WorldTopics
from hitab_world.simulating.control import Control
from hitab_world.simulating.lockstep import RoundAnswers
from hitab_world.simulating.run_state import RunState
from hitab_world.simulating.world_memory import WorldMemory
from hitab_world.world import LOOK, RESTART, LiveWorld, World

NAMED_MAX = 10  # maximum number of agents that an error names
TURN, STEP, REFUSED, LATE, WAITING = "turn", "step", "refused", "late", "waiting"  # faults
UNSAVED_FAULT = "unsaved"
STEPPED_DEADLINES = 3  # how many deadlines to wait for answers in a stepped cycle
HOSTS_TIMEOUT_NS = 60 * NANOSECONDS  # time without a new host, after which none is waited for
UNREAD_MAX = 100  # maximum number of events handled after a deadline, to find unread answers


class WorldNode(GuardedNode):
    """A world in the namespace of its name.

    `run` is the process's main loop: a cycle sends a percept to each agent, waits for their
    answers (lockstep) or for the time to pass (real time), and advances the world. While paused,
    the world sends percepts at each change, so that a demonstrator's next command is recorded
    with the current percept.
    """

    def __init__(self, make_world: Callable[[Node, int], World]) -> None:
        """Create the node and its world.

        Args:
            make_world: creates the world; called with this node, for its parameters, and the seed.

        Raises:
            HitabError: if a parameter is unusable.
        """
        super().__init__("world", enable_rosout=True, start_parameter_services=True)
        self._diagnostics = Diagnostics(self, self._diagnoses)
        self.settings = settings = WorldSettings.declare(self)
        self.world = make_world(self, settings.seed)
        self._live_world = self.world if isinstance(self.world, LiveWorld) else None
        self.control = Control(settings.pace, settings.factor, settings.paused, settings.teaching)
        # Rounds are numbered from the time of day, so that a restarted world has new numbers.
        self._sequence = time.time_ns()
        self._next_cycle_ns = 0
        self._next_status_ns = 0
        self._percept_sender = PerceptSender(self, tuple(self.world.agents), hosts=settings.hosts)
        self.round_answers = RoundAnswers(self.world.agents, self._percept_sender.has)
        self.run_state = RunState(self.world, self.control, self.round_answers)
        warn = self.get_logger().warning
        unsaved = partial(self.guard.faults.set, UNSAVED_FAULT)
        self.memory = WorldMemory(names.own_name(self), self.run_state, settings, warn, unsaved)
        self._topics = WorldTopics(self, self.run_state, settings)
        self._stop_states = self.create_publisher(msg.StopState, names.STOP_STATE, qos.STREAM)

    def join(self) -> None:
        """Start to listen and answer; call this once the name is known to be free."""
        swarm = SwarmSettings(self.settings.swarm, self.settings.machines)
        self._percept_sender.join(self.round_answers.take, swarm, self._topics.report_error)
        self._restored = self.memory.restore()
        if self._restored:
            self.run_state.go_on()
        self._awaited_hosts = 0 if self._restored else self.settings.hosts
        self._hosts_until_ns = time.monotonic_ns() + HOSTS_TIMEOUT_NS
        self._world_services = WorldServices(
            self, self.run_state, self.memory, self._topics, self.update_presence
        )
        self._switch = EmergencySwitch(self, self._emergency, hands_on=True)
        steady_timer(self, HEARTBEAT_S, self._publish_stop_state)

    def _emergency(self, known: KnownStops) -> None:
        """Hold the world while an emergency stop is engaged; then continue as before."""
        self.control.held = stopped_by(known)
        self.run_state.disturbed = True
        held = self.control.held
        self.guard.faults.set("stop", held and f"{STOPPED}: {held}", Fix.GO())
        self._publish_stop_state()

    def _publish_stop_state(self) -> None:
        held = self.control.held
        state = StopState.STOPPED if held else StopState.ARMED
        causes = [held] if held else []
        self._stop_states.publish(stop_report(self, state, causes, held, self._switch))

    def farewell(self) -> None:
        """Save the world's state."""
        self.memory.save_latest()

    def update_presence(self) -> bool:
        """Update which agents have joined the world; return whether any has joined or left."""
        replaced = self._percept_sender.look()
        return self.round_answers.look() or replaced

    # -- the main loop ----------------------------------------------------------------------

    def run(self, spinning: Spinner) -> int:
        """Run the world until the spinner is stopped; return the exit code."""
        if self._restored and self.control.episodes_left:
            # The client that waits for these episodes has to discover this process first.
            spinning.spin_until(lambda: self._topics.episodes_are_heard, ANSWER_S)
        while not spinning.stopped:
            if not self.guard.run(TURN, self._turn, spinning):
                self._pause(TURN)
                spinning.spin_once(timeout_sec=0.1)
        return spinning.exit_code

    def _turn(self, spinning: Spinner) -> None:
        """Take one turn: wait, show the world, or play a cycle."""
        self._publish_periodically()
        self.memory.save_if_due()
        if not self._can_step():
            spinning.spin_once(timeout_sec=0.01)
        elif self.control.at_rest:
            if self.run_state.disturbed:
                self._show(spinning)
            spinning.spin_once(timeout_sec=0.1)
        elif self._awaited_hosts or (self.control.lockstep and not self.round_answers.present):
            spinning.spin_once(timeout_sec=0.1)  # percepts would only delay the start of the rest
        else:
            if self.run_state.begins:
                self._begin_run(spinning)
            self._cycle(spinning)

    def _begin_run(self, spinning: Spinner) -> None:
        """Begin a run; in lockstep, with a look-only round for all agents.

        That round makes the world wait again for agents that missed a deadline in an earlier run.
        Otherwise a run without them would have no missed deadline.
        """
        self.run_state.begins = False
        if self.control.lockstep:
            self._show(spinning)
            self.run_state.restart = True

    def _pause(self, fault: str) -> None:
        """Pause after an error of the world itself, until a person resumes the world."""
        self.control.pause()
        self._topics.report_error(f"paused: {self.guard.faults.text(fault)}")

    def _can_step(self) -> bool:
        """Keep a world that runs by itself alive; return whether the world can be stepped."""
        world = self._live_world
        if world is None:
            return True
        alone = self.control.lockstep and not self.round_answers.present
        if world.waiting or alone or self.control.at_rest:
            happened = world.idle()
            if happened == RESTART:
                self.run_state.mark_restart()
            elif happened == LOOK:
                self.run_state.disturbed = True
        if world.waiting:
            self.guard.log(world.waiting)
        self.guard.faults.set(WAITING, world.waiting)
        return not world.waiting

    def _publish_periodically(self) -> None:
        now = time.monotonic_ns()
        if now >= self._next_status_ns:
            self._next_status_ns = now + NANOSECONDS
            changed = self.update_presence()
            if changed:
                self._hosts_until_ns = now + HOSTS_TIMEOUT_NS
            if self._percept_sender.hosts >= self._awaited_hosts or now >= self._hosts_until_ns:
                self._awaited_hosts = 0
            if changed and not self.control.at_rest:
                self.run_state.in_real_time = True  # the cycle of their arrival depends on a clock
            if changed or (self.round_answers.silent and self.control.paused):
                self.run_state.disturbed = True  # send percepts again, for late agents to answer
            self._topics.publish_status()
            # Nodes on simulated time need the clock from a paused world, too.
            self._topics.publish_clock()

    def _show(self, spinning: Spinner) -> None:
        """Make the agents perceive the present world without acting."""
        self.run_state.disturbed = False
        self._send_percepts(look=True)
        self._wait(spinning, self._deadline())
        if self.run_state.disturbed or spinning.stopped:
            return  # no agent counts as late, since the wait was cut short
        self.run_state.restart = self.run_state.back = False
        self.round_answers.give_up_on_late()
        self._topics.publish_status()  # comes first: clients that get the state read the status
        self._topics.publish_state()

    def _cycle(self, spinning: Spinner) -> None:
        run_state = self.run_state
        run_state.disturbed = False
        lockstep = self.control.lockstep
        run_state.in_real_time |= not lockstep
        self._send_percepts(look=False)
        self._wait(
            spinning, self._deadline() if lockstep else self._next_cycle(), whole=not lockstep
        )
        if lockstep and self.control.steps_left:
            self._wait_for_stepped(spinning)
        if holds := self.round_answers.holds:
            reasons = [holds[name] for name in sorted(holds)]
            run_state.hold(some(reasons, NAMED_MAX, "; "))
            return
        if run_state.disturbed or spinning.stopped:
            return  # the answers belong to an earlier situation
        run_state.restart = run_state.back = False
        late = ""
        if not self.round_answers.complete:
            names_of_late = self.round_answers.count_late(exclude=lockstep)
            late = f"no answer in time from {some(names_of_late, NAMED_MAX)}"
            self.guard.log(f"{late} in cycle {self.world.cycle}", late)
        if late or not self.round_answers.silent:
            self.guard.faults.set(LATE, late)
        self._advance()

    def _wait_for_stepped(self, spinning: Spinner) -> None:
        """Wait longer for agents that are still present, since a client steps the world.

        The person sees and teaches each single cycle. On a busy machine, a cycle without an
        agent's action would teach a wrong example.
        """
        for _ in range(STEPPED_DEADLINES - 1):
            late = self.round_answers.late
            if not late or self.run_state.disturbed:
                return
            self.guard.faults.set(LATE, f"waits for {some(late, NAMED_MAX)}")
            self._topics.publish_status()
            if self.update_presence():
                return
            self._wait(spinning, self._deadline())

    def _deadline(self) -> int:
        """Return the time of the deadline for answers."""
        return time.monotonic_ns() + int(self.settings.deadline * NANOSECONDS)

    def _next_cycle(self) -> int:
        """Return the time at which the next cycle begins in real time."""
        now = time.monotonic_ns()
        period = int(self.world.cycle_seconds / self.run_state.speed * NANOSECONDS)
        # After a pause or a delay the world continues from now instead of catching up.
        behind = now - self._next_cycle_ns > 5 * period
        self._next_cycle_ns = (now if behind else self._next_cycle_ns) + period
        return self._next_cycle_ns

    def _wait(self, spinning: Spinner, deadline_ns: int, *, whole: bool = False) -> None:
        """Handle events until all have answered; with ``whole``, until the deadline."""
        round_answers, run_state = self.round_answers, self.run_state
        spin_once = spinning.spin_once
        while not run_state.disturbed and not spinning.stopped:
            if not whole and round_answers.complete:
                return
            left = deadline_ns - time.monotonic_ns()
            if left <= 0:
                break
            spin_once(timeout_sec=min(left / NANOSECONDS, 0.1))

        # If this process itself was delayed, answers that came in time are still unread.
        for _ in range(UNREAD_MAX):
            if round_answers.complete or run_state.disturbed or spinning.stopped:
                return
            spin_once(timeout_sec=0.0)

    def _send_percepts(self, *, look: bool) -> None:
        world = self.world
        self._sequence += 1
        self.round_answers.begin(self._sequence, look=look)
        common = {
            "stamp": time_of(world.cycle * world.cycle_seconds),
            "sequence": self._sequence,
            "cycle": world.cycle,
            "episode": world.episode,
            "seed": world.seed,
            "look": look,
            "lockstep": self.control.lockstep,
            "restart": self.run_state.restart,
            "back": self.run_state.back,
        }
        self._percept_sender.send(common, self._percept)

    def _percept(self, agent: str) -> tuple[Sequence[float], Sequence[str]] | None:
        """Return an agent's percept; None, and a fault, if the world fails to return it."""
        key = f"percept of {agent}"
        try:
            values, heard = self.world.percept(agent)
            sensed = array("d", values), heard
        except Exception as error:
            self.guard.failed(key, error)
            self.round_answers.excuse(agent)
            return None
        self.guard.faults.clear(key)
        return sensed

    def _advance(self) -> None:
        world, last_minute = self.world, self.run_state.last_minute
        try:
            if last_minute is not None:
                last_minute.note(self.round_answers.answers)
            ended = world.step(self.round_answers.answers)
        except Exception as error:
            self.guard.failed(STEP, error)
            self._pause(STEP)
            self.run_state.disturbed = True  # viewers may have seen no state of it yet
            return
        self.guard.faults.clear(STEP)
        refused = some(list(world.refused.values()), NAMED_MAX, "; ")
        if refused:
            self.guard.log(refused)
        self.guard.faults.set(REFUSED, refused)
        control, topics = self.control, self._topics
        topics.publish_clock()
        if control.steps_left:
            control.steps_left -= 1
        if ended is not None:
            topics.publish_episode(ended)
            self.run_state.end_episode()
        if control.at_rest:
            self.run_state.disturbed = True  # for viewers
        else:
            topics.publish_state_if_due(at_once=ended is not None)
            topics.publish_whether_taught()

    def _diagnoses(self) -> list[Diagnosis]:
        where = self.get_namespace()
        return [diagnosis_of_world(self.run_state, self.guard, where, {TURN, STEP})]

    def faults_changed(self) -> None:
        """Publish the status soon, at the next turn."""
        self._diagnostics.soon()
        self._next_status_ns = min(
            self._next_status_ns, time.monotonic_ns() + int(AT_ONCE_S * NANOSECONDS)
        )


def run_world(make_world: Callable[[Node, int], World]) -> NoReturn:
    """Run a world as this process until stopped; then close the world, if it has ``close``."""
    sys.exit(run(partial(_start, make_world)))


def _start(make_world: Callable[[Node, int], World], spinning: Spinner) -> Loop:
    """Create the node of a world and return the loop that runs it.

    Raises:
        HitabError: if a parameter is unusable, or a world of this name is already running.
    """
    node = WorldNode(make_world)
    spinning.executor.add_node(node)
    check_name_is_free(spinning, [node], msg.WorldStatus)
    node.join()
    if not node.world.agents:
        raise HitabError("the world has no agents; set its parameters for at least one")
    give_signs_of_life(node, node.settings.swarm)

    def run_and_close(spinning: Spinner) -> int:
        try:
            return node.run(spinning)
        finally:
            if close := getattr(node.world, "close", None):
                close()

    return run_and_close
