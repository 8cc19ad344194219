"""Simulated people who train keepers as people do: late, wavering, distracted, and mistaken.

A person has an intention (`intentions`), arranges situations (`practice`), demonstrates each plan
from the bottom up while the world runs, then lets the keeper try, watches, takes over and corrects
when it does what was not intended (`trial`), and goes on to the next plan when content or when the
budget for this one is spent. A person knows what the field and the status show, not how the engine
learns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from random import Random

from habits import Diary, Habits
from intentions import Intention, Plan
from practice import SCENES, Scene, being_open, having_the_ball, playing
from pupils import Pupil
from second_thoughts import SecondThoughts, as_seen
from trial import Kind, Memory, Trial, begins
from ways import AS_THEY_ARE, Timing, Ways

from hitab_core import START
from hitab_core.example import Example

SHARES = (14 / 60, 29 / 60, 44 / 60, 1.0)
"""The part of the budget that may be spent by the end of each plan."""

NOTICED = 2
"""A plan goes wrong that did what was not intended in so many trials of what is made of it."""

MENDING = 6
"""The most examples that are given to a plan to which a person goes back, before going on."""

MENDED = 47 / 60
"""The part of the budget that may be spent by then: the rest is for the top-level plan."""

ROUNDS = 3
"""How often a person goes back from the games to what goes wrong in them."""

AGAIN = 3
"""How often a person shows what to begin with before giving up."""


class Person:
    """One simulated person.

    Args:
        intention: what the team should do.
        habits: how the person acts.
        seed: of everything that the person draws.
        budget: the most examples that the trainings may hold, default ones counted.
        estimated: whether the agent estimates how late the person's commands come.
        reviews: whether the person looks through what was recorded after each trial.
        answers: whether the person answers the keeper's questions.
        slows: whether the person slows the world down where commands come too late.
        ways: how the person presses keys and uses time.
    """

    def __init__(
        self,
        intention: Intention,
        habits: Habits,
        seed: int,
        budget: int = 60,
        *,
        estimated: bool = False,
        reviews: bool = False,
        answers: bool = False,
        slows: bool = False,
        ways: Ways = AS_THEY_ARE,
    ) -> None:
        self.intention = intention
        self.habits = ways.habits(habits)
        self.timing = Timing(ways, self.habits, seed)
        self.budget = budget
        self.diary = Diary()
        self.random = Random(f"person {seed}")
        self.estimated = estimated
        self.contradicts = reviews or estimated
        self.reviews, self.slows = reviews, slows
        self.answers = answers
        self.trusts = self.answers_between = False

    # -- the whole course -------------------------------------------------------------------

    def train(self, pupil: Pupil) -> Diary:
        """Train all plans of the intention, from the bottom up."""
        *lower, top = self.intention.plans
        courses = []
        for plan, share in zip(lower, SHARES, strict=False):
            course = Course(self, pupil, plan, int(share * self.budget))
            courses.append(course)
            pupil.perform("")
            pupil.begin(plan)
            course.practise(SCENES[plan.name], guided=2)
            if not course.save():
                return self._ended(pupil, plan)
            self._mend_below(pupil, course, courses)
        team = self._train_team(pupil, top)
        if team is None:
            return self._ended(pupil, top)

        # The first time, some of what is left of the budget is kept for the games themselves.
        for kept in (MENDING, *[0] * (ROUNDS - 1)):
            self._mend(pupil, courses, team, self.budget - (0 if team.content else kept))
            if not team.content:
                pupil.perform(top.name)
                pupil.begin(top, resume=True)
                self._bootstrap(team, top)
            if team.content or team.exhausted:
                break
        return self.diary

    def _mend(self, pupil: Pupil, courses: Sequence[Course], team: Course, allowance: int) -> None:
        """Go back to what is not good yet, as far as the budget allows.

        First to what went wrong in games, then to what lost a command.
        """

        def urgency(course: Course) -> tuple[int, bool]:
            return -team.troubles[course.plan.name], not course.memory.lost

        for course in sorted(courses, key=urgency):
            name = course.plan.name
            course.allowance = allowance
            content = name in self.diary.content and team.troubles[name] < NOTICED
            if not content and not course.exhausted:
                self._resume(pupil, course)

    def _resume(self, pupil: Pupil, course: Course) -> None:
        """Go on with the training of a plan."""
        pupil.perform("")
        pupil.begin(course.plan, resume=True)
        course.practise(SCENES[course.plan.name], guided=1)
        course.save()

    def _mend_below(self, pupil: Pupil, course: Course, courses: Sequence[Course]) -> None:
        """Go back to the plan that hinders this one, and show again what this one has lost."""
        if course.plan.name in self.diary.content:
            return
        hindering = [c for c in courses if course.troubles[c.plan.name] >= NOTICED]
        hindering.sort(key=lambda c: -course.troubles[c.plan.name])
        for again in (*hindering[:1], *([course] if hindering or course.memory.lost else [])):
            again.allowance = min(int(MENDED * self.budget), pupil.held + MENDING)
            self._resume(pupil, again)

    def _ended(self, pupil: Pupil, plan: Plan) -> Diary:
        self.diary.failure = f"{plan.name} has no example for {START}"
        return self.diary

    def _train_team(self, pupil: Pupil, plan: Plan) -> Course | None:
        """Bootstrap the top-level plan; return its course, None if there is nothing to perform.

        First the mates stand idle, then they perform what has been trained so far.
        """
        pupil.perform("")
        pupil.begin(plan)
        course = Course(self, pupil, plan, self.budget)
        for scene in (having_the_ball, being_open):
            course.demonstrate(scene, seconds=0.6)
        if not course.hand_out(plan):
            return None
        return course if self._bootstrap(course, plan) else None

    def _bootstrap(self, course: Course, plan: Plan) -> bool:
        """Train the top-level plan among teammates who perform it; see `_train_team`."""
        for stage in (having_the_ball, being_open):
            course.practise(stage, guided=1, content=1, trials=4)
            if not course.hand_out(plan):
                return False
        course.troubles.clear()
        course.practise(playing, guided=0, content=4, trials=16)
        return course.save()


class Course:
    """Training one plan: trials until the person is content.

    Attributes:
        troubles: in how many trials each plan below did what was not intended.
        content: whether the person was content in the end.
    """

    def __init__(self, person: Person, pupil: Pupil, plan: Plan, allowance: int) -> None:
        self.person, self.pupil, self.plan, self.allowance = person, pupil, plan, allowance
        self.memory = Memory()
        self.troubles: Counter[str] = Counter()
        self.content = False
        self.turn = 0

    # -- trials -----------------------------------------------------------------------------

    def practise(
        self,
        scenes: Callable[[Random, int], Scene],
        *,
        guided: int,
        content: int | None = None,
        trials: int | None = None,
    ) -> None:
        """Demonstrate a few times, then let the keeper try until content or out of budget."""
        wanted = self.person.habits.content if content is None else content
        clean, self.content = 0, False
        for trial in range(self.person.habits.trials if trials is None else trials):
            if self.exhausted:
                break
            hand = trial < guided or bool(self.memory.early)
            again, self.memory.again = self.memory.again, None
            scene = again or self._next(scenes)
            first = again is not None
            good = self._play(scene, guided=hand or first, first=first)
            if self.person.answers_between:
                self._forget(self.trial(), self._between())
            clean = clean + 1 if good and not hand else 0
            if clean >= wanted:
                self.person.diary.content.append(self.plan.name)
                self.content = True
                break
        if self.person.answers:
            self._forget(self.trial(), self._second_thoughts().answer(self.allowance))

    def _play(self, scene: Scene, *, guided: bool, first: bool = False, **more: float) -> bool:
        """Play one situation, and look through what was recorded; see `Trial.play`."""
        trial = self.trial()
        good = trial.play(scene, guided=guided, first=first, **more)
        if self.person.reviews:
            self._forget(trial, self._second_thoughts().review(trial.given))
        self._settle(trial)
        self.troubles.update(trial.troubled)
        return good

    def _settle(self, trial: Trial) -> None:
        """Answer which of contradicting commands hold."""
        if self.person.answers:
            self._forget(trial, self._second_thoughts().settle())

    def _forget(self, trial: Trial, deleted: Iterable[Example]) -> None:
        """Note which decisions are no longer shown, since their only commands were deleted."""

        def kinds(examples: Iterable[Example]) -> set[Kind]:
            return {
                trial.kind(e.state, e.next_state, as_seen(self.plan, e.features)) for e in examples
            }

        gone = kinds(deleted) - kinds(self.pupil.examples())
        self.memory.shown -= gone
        self.memory.lost |= gone

    def _between(self) -> list[Example]:
        """Answer questions between two trials; return the examples that this has deleted."""
        return self._second_thoughts().answer(self.allowance, self.person.timing.ways.answers)

    def _second_thoughts(self) -> SecondThoughts:
        person = self.person
        return SecondThoughts(self.pupil, self.plan, person.habits, person.random, person.diary)

    def _next(self, scenes: Callable[[Random, int], Scene]) -> Scene:
        self.turn += 1
        return scenes(self.person.random, self.turn - 1)

    def trial(self) -> Trial:
        """Return a trial of this plan, to be played."""
        person = self.person
        return Trial(
            self.pupil,
            self.plan,
            person.habits,
            person.random,
            person.diary,
            self.memory,
            self.allowance,
            contradicts=person.contradicts,
            slows=person.slows,
            trusts=person.trusts,
            estimated=person.estimated,
            settle=self._settle,
            below={p.name: p for p in person.intention.plans if p is not self.plan},
            timing=person.timing,
        )

    def demonstrate(self, scenes: Callable[[Random, int], Scene], seconds: float) -> None:
        """Play a situation for a short while under guidance."""
        self._play(self._next(scenes), guided=True, seconds=seconds)

    @property
    def exhausted(self) -> bool:
        """Whether this plan may hold no more."""
        return self.pupil.held + 2 > self.allowance

    def hand_out(self, plan: Plan) -> bool:
        """Save what there is, have all mates perform it, and go on training it."""
        if not self.save():
            return False
        self.pupil.perform(plan.name)
        self.pupil.begin(plan, resume=True)
        return True

    def _note_moments(self) -> None:
        """Note how far off commands are recorded, before the next training begins."""
        for e in self.pupil.examples():
            meant = self.memory.meant.pop(e.number, None)
            if meant is not None:
                ago, left = meant
                self.person.diary.off.append((ago - e.ago, e.state != left))

    def save(self) -> bool:
        """Save what there is, and show before what to begin with if that was lost.

        Returns:
            Whether there was anything.
        """
        scenes = SCENES.get(self.plan.name, having_the_ball)
        for _ in range(AGAIN):
            if not begins(self.pupil) and not self.exhausted:
                self.demonstrate(scenes, seconds=0.6)
        if not begins(self.pupil):
            return False
        self._note_moments()
        self.pupil.save(keep_unused=True)
        return True
