"""The run state of a world: its control, its agents and its episodes."""

from __future__ import annotations

import time

from hitab_core import HitabError
from hitab_world.simulating.control import Control
from hitab_world.simulating.last_minute import LastMinute
from hitab_world.simulating.lockstep import RoundAnswers
from hitab_world.world import LiveWorld, World


class RunState:
    """The state of a run, shared by the parts that play, publish, save and change a world.

    Attributes:
        world: the world.
        control: the settings that services change.
        round_answers: the agents that take part, and their answers.
        changes: number of the last change from outside, unique among all processes.
        disturbed: whether the world has changed since its last percepts.
        restart: whether agents begin at Start with the next percept.
        back: whether the world went back to this cycle since its last percepts.
        begins: whether a run begins with the next cycle.
        in_real_time: whether the run has depended on a clock.
        touched: whether the world was changed from outside since it was last saved.
        last_minute: what it can be put back to; None of a world that runs by itself.
    """

    def __init__(self, world: World, control: Control, round_answers: RoundAnswers) -> None:
        self.world = world
        self.control = control
        self.round_answers = round_answers
        self.changes = time.time_ns()
        self.disturbed = True
        self.restart = True
        self.back = False
        self.begins = False
        self.in_real_time = False
        self.touched = False
        self.last_minute = None if isinstance(world, LiveWorld) else LastMinute(world)

    @property
    def reproducible(self) -> bool:
        """Whether the same seed gives the same run: no late answers, and no clock involved."""
        return not (self.in_real_time or self.round_answers.missed_deadlines)

    @property
    def speed(self) -> float:
        """Speed in real-time pace, as a factor of real time.

        A world that runs by itself cannot be slowed down.
        """
        slowed = self.last_minute is not None and self.round_answers.taught
        return self.control.factor * (self.control.teaching if slowed else 1.0)

    def go_on(self) -> None:
        """Continue a run that another process began.

        Running agents continue, and the world plays the cycles after the snapshot again.
        """
        self.restart = False
        self.in_real_time = True

    def begin_run(self, seed: int) -> None:
        """Begin the first episode of a run, which counts as reproducible so far."""
        self.round_answers.missed_deadlines = 0
        self.in_real_time = False
        self.control.run += 1
        self.begins = True
        self.begin_episode(0, seed)

    def begin_episode(self, number: int | None = None, seed: int | None = None) -> None:
        """Begin the next episode, or the given one; agents begin at Start."""
        self.world.reset(number, seed)
        self.mark_restart()
        self.touched = True

    def end_episode(self) -> None:
        """Count the ended episode, and begin the next; pause if it was the last to play."""
        control = self.control
        if control.episodes_left:
            control.episodes_left -= 1
            if not control.episodes_left:
                control.pause()
        self.begin_episode()

    def mark_restart(self) -> None:
        """Make the agents begin at Start with the next percept, whatever they have held for."""
        self.round_answers.holds.clear()
        self.restart = self.disturbed = True
        self.back = False

    def change(self) -> None:
        """Mark the world as changed from outside: show it to the agents and save it."""
        self.disturbed = True
        self.touched = True
        if self.last_minute is not None:
            self.last_minute.cut()

    def hold(self, why: str) -> None:
        """Pause before the present cycle, since an agent holds the world there.

        The other agents have acted already, so they go back.
        """
        self.control.pause(why)
        self.restart = False
        self.back = self.disturbed = True

    def go_back(self, cycle: int) -> None:
        """Put the world back to a cycle of the last minute, where it pauses.

        Raises:
            HitabError: if that is not possible; nothing has changed then.
        """
        if self.last_minute is None:
            raise HitabError(
                "a world that runs by itself, as on another server, cannot go back; go back in a "
                "simulation"
            )
        self.last_minute.go_back(cycle)
        self.control.pause()
        self.back = self.disturbed = self.touched = self.in_real_time = True
