"""The course of a world: how it is run, who takes part, and its episodes."""

from __future__ import annotations

from hitab_world.attendance import Attendance
from hitab_world.control import Control
from hitab_world.world import World


class Course:
    """What those have in common who run a world, publish it, keep it, or change it on request.

    Attributes:
        world: the world.
        control: how it is run.
        attendance: who takes part.
        disturbed: whether the world has become another than the agents were shown.
        restart: whether agents begin at Start with the next percept.
        in_real_time: whether a clock has taken part in the run.
        touched: whether the world was changed from outside since it was kept.
    """

    def __init__(self, world: World, control: Control, attendance: Attendance) -> None:
        self.world = world
        self.control = control
        self.attendance = attendance
        self.disturbed = True
        self.restart = True
        self.in_real_time = False
        self.touched = False

    @property
    def reproducible(self) -> bool:
        """Whether the same seed gives this run again: nobody was late, and no clock took part."""
        return not (self.in_real_time or self.attendance.missed_deadlines)

    def go_on(self) -> None:
        """Go on with a run that another process began.

        Agents that live on do not begin anew, and what came after the snapshot comes again.
        """
        self.restart = False
        self.in_real_time = True

    def begin_run(self, seed: int) -> None:
        """Begin the first episode of a run, and to count what would make it another one."""
        self.attendance.missed_deadlines = 0
        self.in_real_time = False
        self.begin_episode(0, seed)

    def begin_episode(self, number: int | None = None, seed: int | None = None) -> None:
        """Begin the next episode, or the given one; agents begin at Start."""
        self.world.reset(number, seed)
        self.mark_restart()
        self.touched = True

    def end_episode(self) -> None:
        """Count an episode that has ended, and begin the next; pause if it was the last."""
        control = self.control
        if control.episodes_left:
            control.episodes_left -= 1
            if not control.episodes_left:
                control.pause()
        self.begin_episode()

    def mark_restart(self) -> None:
        """Have the agents begin at Start with the next percept."""
        self.restart = True
        self.disturbed = True

    def change(self) -> None:
        """Show the agents, and keep soon, a world that was changed from outside."""
        self.disturbed = True
        self.touched = True
