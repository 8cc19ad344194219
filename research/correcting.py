"""People who correct a saved team, or retrain one, with a limited number of commands."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from changed_worlds import Change
from habits import Habits
from intentions import Plan
from practice import SCENES
from pupils import InProcessPupil
from second_thoughts import as_seen
from simulated_people import Course, Person

from hitab_core import START
from hitab_core.example import Example

SHIPPED = Path(__file__).parents[1] / "ros2_ws/src/keepaway_world/libraries/keepaway"
MOST = 5
"""The most corrections of a repair."""

ENOUGH = 10_000
"""Nobody counts examples; a pupil that takes no more commands says that it holds more."""

WATCHED = 8
"""The most trials that a person watches of a plan in a repair."""

PUNCTUAL = Habits(reaction=(0.0, 0.0), inattention=0.0, overlooks=0.0)
"""In time, and wavering as all people do."""

MOVED = {"near": {("Stop", "Pass")}}
"""The decisions that each edge which a change moves is about."""


class CountingPupil(InProcessPupil):
    """A team in a changed world that takes only so many commands.

    Args:
        seed: of the world and the agents.
        change: of the world.
        most: commands that it takes.
        library: what it has learned before.

    Attributes:
        learning: how long each command took to be recorded and learned from, s.
    """

    def __init__(
        self, seed: int, change: Change, most: int = ENOUGH, library: Path | None = None
    ) -> None:
        super().__init__(seed, change.parameters, world=change.world, library=library)
        self.most = most
        self.learning: list[float] = []

    @property
    def held(self) -> int:
        """Return the examples held, or too many if no more commands are taken."""
        return ENOUGH if len(self.learning) >= self.most else super().held

    def command(self, state: str, pace: float = 0.0) -> Sequence[Example]:
        """Command the keeper, and learn from it at once."""
        began = time.perf_counter()
        taught = super().command(state, pace)
        if any(example.state == START for example in self._session.examples):
            self._session.automaton()
        self.learning.append(time.perf_counter() - began)
        return taught

    def forget(self, numbers: Sequence[int]) -> None:
        """Delete examples instead of as many commands."""
        if numbers:
            self.delete(numbers)
            self.most -= len(numbers)


def corrected(
    change: Change, seed: int, *, afresh: bool = False, deletes: bool = True
) -> CountingPupil:
    """Return the shipped team after at most five commands to the plans that are to change.

    Args:
        change: of the world.
        seed: of the person and of the world in which the person trains.
        afresh: throw away what these plans were shown before.
        deletes: delete commands that are wrong now, which counts as correcting.
    """
    person = Person(change.intention, PUNCTUAL, seed, reviews=True)  # answers would be corrections
    pupil = CountingPupil(seed, change, MOST, SHIPPED)
    for plan in change.intention.plans:
        moved = set[tuple[str, str]]().union(
            *(MOVED[name] for name in plan.edges if name in change.edges)
        )
        if not moved:
            continue
        pupil.perform("")
        pupil.begin(plan, resume=not afresh)
        course = Course(person, pupil, plan, ENOUGH)
        if not afresh:  # the keeper still knows the rest
            if deletes:
                pupil.forget(outdated_in(pupil, plan))
            trial = course.trial()
            course.memory.shown |= {
                trial.kind(e.state, e.next_state, as_seen(plan, e.features))
                for e in pupil.examples()
                if (e.state, e.next_state) not in moved
            }
        course.practise(SCENES[plan.name], guided=2 if afresh else 1, trials=WATCHED)
        course.save()
    return pupil


def outdated_in(pupil: CountingPupil, plan: Plan) -> list[int]:
    """Return the numbers of the commands to which a person with a plan objects."""
    return [
        e.number
        for e in pupil.examples()
        if not e.is_default
        and e.next_state not in plan.fitting(e.state, as_seen(plan, e.features))
    ]


def retrained(change: Change, seed: int, most: int = ENOUGH) -> CountingPupil:
    """Return a team that a person has trained from nothing, with so many commands at most."""
    pupil = CountingPupil(seed, change, most)
    few = most < ENOUGH
    person = Person(change.intention, PUNCTUAL, seed, reviews=True, answers=not few)
    person.train(pupil)
    return pupil
