"""Novices at real pace: in the studio, by keys on its page in a real browser, or over topics.

The same novices as in `teachers.py` train `Chase`, one plan, and the whole `Keepaway` hierarchy
while the world runs in real time. What they see and how late they are is the same; what they
command goes the way of a person's command, from the key to the page, the studio and the agent.
Automata are begun and saved, and the field is arranged, over topics and services.

    scripts/python research/late_keys.py --people 5
    scripts/python research/late_keys.py --people 5 --by topics
    scripts/python research/late_keys.py --people 5 --what chase
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from random import Random
from statistics import fmean
from typing import Annotated, Any

import typer
from finished_runs import FinishedRuns, Resume
from habits import Diary
from intentions import KICKABLE, OFF, Edges, Intention, Plan, Seen
from novices import DEMONSTRATIONS, NOVICE, UNCOUNTED, WATCHED, Novice
from practice import going
from pupils import Pupil, Sight
from simulated_people import Course
from teachers import PAPER_S, hold_times, intention_of, own_hold_times, playing
from topic_pupil import PUPIL, TopicPupil

from hitab_core import START, Automaton, Example, HitabError, Repertoire, Term
from hitab_core.assistant.question import QuestionKind
from hitab_core.running import FeatureCache, RunningAutomaton
from hitab_world import Placement
from hitab_world.inprocess import AutomatonPlayer, cycle, perform
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from browsing import browser, studio

EPISODES = 200

SECONDS = 20.0
"""What takes longer has failed."""


def chase(state: str, seen: Seen, edges: Edges) -> str:
    """Turn to the ball, run while it is ahead, stop at it."""
    if seen[KICKABLE]:
        return "Stop"
    off = abs(seen[OFF])
    if state == "GoFast":
        return "TurnToBall" if off > edges["off"] else state
    return "GoFast" if off < edges["ahead"] else "TurnToBall"


CHASE = Plan(
    "Chase",
    ("TurnToBall", "GoFast", "Stop"),
    (OFF, KICKABLE),
    chase,
    {"off": 0.35, "ahead": 0.12},
)
CHASING = Intention("chase", "turn to the ball, run to it, stop", (CHASE,))


class By(StrEnum):
    """How people command."""

    PAGE = "page"
    TOPICS = "topics"


class RealTimePupil(TopicPupil):
    """A team of nodes in a world that does not wait.

    Args:
        seed: of the world and the agents.
    """

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._world.control("pace", pace="realtime", factor=1.0)
        self._seen = 0

    def place(self, placements: Iterable[Placement], *, new_episode: bool = True) -> Sight:
        """Arrange the field while the world is paused; see `Pupil.place`."""
        self._world.control("pause")
        return super().place(placements, new_episode=new_episode)

    def step(self) -> Sight:
        """Watch until the next cycle; the first one after arranging the field lets it run."""
        before = self._world.state_at(0)
        if self._world.is_paused:
            self._world.control("resume")
            self._seen = before.cycle
        self._seen += 1
        after = self._world.state_at(self._seen)
        if after.episode != before.episode:
            self._path = [START]
        return self._sight(ended=after.episode != before.episode)

    def contradictions(self) -> int:
        """Return how many commands are asked about, as far as is known at once."""
        found = self._agents.training(PUPIL).questions
        return sum(question.kind == QuestionKind.CONTRADICTION for question in found)


class PagePupil(RealTimePupil):
    """The same, commanded by the keys of the studio's page.

    Args:
        seed: of the world and the agents.
        browser: a Chromium that has been started.
    """

    def __init__(self, seed: int, browser: Any) -> None:
        super().__init__(seed)
        self.page = browser.new_page()
        folder = self._folder.path
        url = self._stack.enter_context(studio(folder / "studio.log", "--run-dir", str(folder)))
        self._stack.callback(self.page.close)
        self.page.goto(url)
        self.page.click(f'[data-test="agent-{PUPIL}"]')

    def command(self, state: str, pace: float = 0.0) -> Sequence[Example]:
        """Press the key of a behavior; see `Pupil.command`."""
        before = max((e.command for e in self.examples()), default=0)
        told = self._too_late()
        button = self.page.wait_for_selector(f'[data-test="do-{state}"]:not([aria-disabled])')
        self.page.keyboard.press(button.get_attribute("data-hotkey"))
        deadline = time.monotonic() + SECONDS
        while not (taught := [e for e in self.examples() if e.command > before]):
            if self._too_late() != told:
                return ()
            if time.monotonic() > deadline:
                shown = self.page.inner_text("body")
                raise HitabError(f"the key for {state} was not recorded; the page shows: {shown}")
        self._path = [state]
        self.given += len(taught)
        return taught

    def _too_late(self) -> list[str]:
        """Return what the page says of keys that came when their episode was over."""
        said = self.page.locator('[data-test="message"]', has_text="a new episode has begun")
        return list(said.all_inner_texts())

    def test(self, *, restart: bool = False) -> None:
        """Press the key that hands over, if the keeper is not being tested, and restart."""
        if self._mode() == "Training":
            self._press_toggle("Testing")
        if restart:
            super().test(restart=True)

    def take_over(self) -> None:
        """Press the key that takes over, if the keeper is being tested."""
        if self._mode() == "Testing":
            self._press_toggle("Training")

    def _press_toggle(self, mode: str) -> None:
        self.page.wait_for_selector('[data-test="toggle"]:not([aria-disabled])')
        self.page.keyboard.press("t")
        self.page.wait_for_selector(f"[data-test=\"mode\"]:has-text('{mode}')")

    def _mode(self) -> str:
        return str(self.page.inner_text('[data-test="mode"]'))


class ChaseNovice(Novice):
    """A novice who trains one plan and watches no games."""

    def train(self, pupil: Pupil) -> Diary:
        """Train the plan, once."""
        (plan,) = self.intention.plans
        pupil.perform("")
        pupil.begin(plan)
        course = Course(self, pupil, plan, UNCOUNTED)
        self._practise(course, going, DEMONSTRATIONS, WATCHED)
        return self.diary if course.save() else self._ended(pupil, plan)


def catches(automaton: Automaton, seed: int, trials: int = 100) -> float:
    """Return in which part of some situations a keeper stops within reach of the ball."""
    world = KeepawayWorld(seed=seed)
    players = perform(world, Repertoire(DOMAIN, {CHASE.name: automaton}), CHASE.name)
    player, caught, reach = players[PUPIL], 0, Term.parse(KICKABLE)
    assert isinstance(player, AutomatonPlayer)
    running = player.running
    assert isinstance(running, RunningAutomaton)
    for trial in range(trials):
        scene = going(Random(f"{seed} {trial}"), trial)
        world.place(scene.start, new_episode=True)
        player.begin(seed, trial)
        for _ in range(round(2.0 * scene.seconds / world.cycle_seconds)):
            ended = cycle(world, {PUPIL: player})
            if running.active == "Stop":
                caught += FeatureCache(player.body, DOMAIN).look(reach) > 0.5
                break
            if ended:
                break
    return caught / trials


def taught(what: str, number: int, seed: int, pupil: RealTimePupil) -> dict[str, Any]:
    """Have one person train a team at real pace; return the figures.

    Args:
        what: ``chase`` or ``keepaway``.
        number: of the person.
        seed: of all people.
        pupil: the team.
    """
    chasing = what == "chase"
    intention = CHASING if chasing else intention_of(number)
    kind = ChaseNovice if chasing else Novice
    person = kind(intention, replace(NOVICE, inattention=0.1), seed * 1000 + number)
    began = time.monotonic()
    diary = person.train(pupil)
    figures = {**diary.figures(), "minutes": (time.monotonic() - began) / 60.0}
    automata = {} if diary.failure else pupil.repertoire.automata
    if chasing:
        own = catches(CHASE.automaton(), seed + 7)
        return figures | {
            "own": own,
            "of": catches(automata[CHASE.name], seed + 7) if automata else 0,
        }
    own, _ = own_hold_times(intention.name, EPISODES, seed + 7)
    play = playing(automata, intention.plans[-1].name, seed + 7)
    return figures | {"own": own, "of": fmean(hold_times(play, EPISODES)) if automata else 0.0}


def main(
    people: Annotated[int, typer.Option(help="How many people.", min=1)] = 5,
    what: Annotated[str, typer.Option(help="chase or keepaway.")] = "keepaway",
    by: Annotated[By, typer.Option(help="How they command.")] = By.PAGE,
    seed: Annotated[int, typer.Option(help="Seed of people and games.")] = 2026,
    resume: Resume = "",
) -> None:
    """Have novices train at real pace, and measure what they get."""
    finished = FinishedRuns(resume, {"what": what, "by": by, "seed": seed})
    with browser() if by is By.PAGE else nullcontext() as chromium:
        for number in range(people):
            name = f"person {number}"
            if name not in finished.figures:
                seed_of = seed * 1000 + number
                pupil = PagePupil(seed_of, chromium) if chromium else RealTimePupil(seed_of)
                try:
                    finished.add(name, taught(what, number, seed, pupil))
                finally:
                    pupil.close()
            one = finished.figures[name]
            counts = one["counts"]
            print(
                f"{name}: {one['of']:.3g}, intended {one['own']:.3g}; {one['minutes']:.1f} min, "
                f"{counts['commands']} commands, {counts.get('answers', 0)} answers",
                one["failure"],
                flush=True,
            )
    found = list(finished.figures.values())
    print(f"{what}, by {by}: {fmean(f['of'] / f['own'] for f in found):.2f} of what was intended")
    if what == "keepaway":
        print(f"{sum(f['of'] >= PAPER_S for f in found)} of {people} reach {PAPER_S} s")


if __name__ == "__main__":
    typer.run(main)
