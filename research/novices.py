"""Simulated novices: late, and careless about what was recorded.

A novice takes 0.3 s to see that something is due, and a log-normal time to choose among the keys
(median 0.3 s; 95 % of both together lie in 0.40 to 1.18 s). What a novice intends is a rule with
thresholds that the novice could not tell as numbers: distances and angles are seen as the picture
of the field shows them, 15 % off, and one robot is watched at a time. Nothing that was recorded
is looked at, no delay is set, no features are exchanged, and nobody goes back to an earlier plan.
Each plan is demonstrated twice, and then a few trials are watched.

These people were fixed before the engine was made for them.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from habits import Diary, Habits
from intentions import Intention, Plan
from practice import SCENES, Scene, being_open, having_the_ball, playing
from pupils import Pupil
from simulated_people import Course, Person
from ways import AS_THEY_ARE, Ways

NOVICE = Habits(
    reaction=(0.3, 0.3), choice=(0.3, 0.55), waver=0.0, sight=0.15, overlooks=1.0, content=3
)

DEMONSTRATIONS = 2
"""How often a novice shows a plan before watching."""

WATCHED = 3
"""How many trials of a plan a novice watches."""

GAMES = 2
"""How many whole games a novice watches."""

UNCOUNTED = 10_000
"""A novice does not count examples."""


class Novice(Person):
    """One simulated novice.

    Args:
        intention: what the team should do.
        habits: how the novice acts.
        seed: of everything that the novice draws.
        answers: whether the novice answers what the keeper asks, one question at a time.
        estimated: whether the agent estimates how late the commands come.
        ways: how the novice presses keys and uses time.
    """

    def __init__(
        self,
        intention: Intention,
        habits: Habits,
        seed: int,
        *,
        answers: bool = True,
        estimated: bool = True,
        ways: Ways = AS_THEY_ARE,
    ) -> None:
        super().__init__(
            intention,
            habits,
            seed,
            UNCOUNTED,
            estimated=estimated,
            answers=answers,
            ways=ways,
        )
        # Whoever sees a robot do the wrong thing presses the key of the right one.
        self.contradicts = self.trusts = True
        # The agent asks when the person is not commanding: after each trial.
        self.answers_between = answers

    def train(self, pupil: Pupil) -> Diary:
        """Train all plans of the intention, from the bottom up, each once."""
        *lower, top = self.intention.plans
        for plan in lower:
            pupil.perform("")
            pupil.begin(plan)
            course = Course(self, pupil, plan, UNCOUNTED)
            self._practise(course, SCENES[plan.name], DEMONSTRATIONS, WATCHED)
            if not course.save():
                return self._ended(pupil, plan)
        if not self._play_with_mates(pupil, top):
            return self._ended(pupil, top)
        return self.diary

    def _play_with_mates(self, pupil: Pupil, plan: Plan) -> bool:
        """Train the top-level plan; return whether there is anything to perform."""
        pupil.perform("")
        pupil.begin(plan)
        course = Course(self, pupil, plan, UNCOUNTED)
        for scene in (having_the_ball, being_open):
            course.demonstrate(scene, seconds=0.6)
        for scenes, shown, watched in (
            (having_the_ball, 1, WATCHED - 1),
            (being_open, 1, WATCHED - 1),
            (playing, 0, GAMES),
        ):
            if not course.hand_out(plan):
                return False
            self._practise(course, scenes, shown, watched)
        return course.save()

    def _practise(
        self, course: Course, scenes: Callable[[Random, int], Scene], shown: int, watched: int
    ) -> None:
        course.practise(scenes, guided=shown, trials=shown + watched)
