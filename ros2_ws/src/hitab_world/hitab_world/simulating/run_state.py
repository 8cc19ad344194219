"""The run state of a world: its control, its agents and its episodes."""

from __future__ import annotations

import time

from hitab_world.simulating.control import Control
from hitab_world.simulating.lockstep import RoundAnswers
from hitab_world.world import World


class RunState:
    """The state of a run, shared by the parts that play, publish, save and change a world.

    Attributes:
        world: the world.
        control: the settings that services change.
        round_answers: the agents that take part, and their answers.
        changes: number of the last change from outside, unique among all processes.
        disturbed: whether the world has changed since its last percepts.
        restart: whether agents begin at Start with the next percept.
        begins: whether a run begins with the next cycle.
        in_real_time: whether the run has depended on a clock.
        touched: whether the world was changed from outside since it was last saved.
    """

    def __init__(self, world: World, control: Control, round_answers: RoundAnswers) -> None:
        self.world = world
        self.control = control
        self.round_answers = round_answers
        self.changes = time.time_ns()
        self.disturbed = True
        self.restart = True
        self.begins = False
        self.in_real_time = False
        self.touched = False

    @property
    def reproducible(self) -> bool:
        """Whether the same seed gives the same run: no late answers, and no clock involved."""
        return not (self.in_real_time or self.round_answers.missed_deadlines)

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
        """Make the agents begin at Start with the next percept."""
        self.restart = True
        self.disturbed = True

    def change(self) -> None:
        """Mark the world as changed from outside: show it to the agents and save it."""
        self.disturbed = True
        self.touched = True
