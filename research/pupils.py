"""What a simulated person trains: a team of keepers in a world that runs.

`Pupil` is all that a person can see and do, as in the studio; `InProcessPupil` is a team in this
process, `topic_pupil.TopicPupil` one of nodes. A person sees what a keeper perceives when the
world has run for a cycle, and commands before the keeper acts on that.
"""

from __future__ import annotations

import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Protocol

from intentions import BALL, CLOSER, DONE, KICKABLE, OFF, TAKER, YELLED, Plan

from hitab_core import Agent, BehaviorLibrary, Given, Repertoire, Term, TrainingSession
from hitab_core.assistant import Question
from hitab_core.assistant.question import QuestionKind
from hitab_core.default_example import marked
from hitab_core.example import Example
from hitab_core.training import Curriculum, example_log
from hitab_world import Placement
from keepaway_world.domain import DOMAIN
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.world import KeepawayWorld

VISIBLE = (BALL, OFF, TAKER, KICKABLE, CLOSER, YELLED)
"""Everything that an intention may depend on, besides flags."""

WHETHER = (KICKABLE, CLOSER, YELLED, DONE)
"""What is so or not so."""


@dataclass(frozen=True)
class Sight:
    """What a person sees after a cycle.

    Attributes:
        state: the active state of what is being trained.
        values: of everything visible, by feature.
        ended: whether the episode has ended.
        below: the active state of each automaton that is performed inside of it, by name.
    """

    state: str
    values: Mapping[str, float]
    ended: bool
    below: Mapping[str, str] = field(default_factory=dict)


class Pupil(Protocol):
    """A team of which one keeper is trained.

    Attributes:
        cycle_seconds: simulated time of a cycle, s.
        given: the number of examples recorded so far in all trainings, deleted ones counted.
        held: the number of examples that all trainings hold now.
    """

    cycle_seconds: float
    given: int

    @property
    def held(self) -> int:
        """Return the number of examples that all trainings hold now."""

    def begin(self, plan: Plan, *, resume: bool = False) -> None:
        """Begin to train an automaton, or resume its training."""

    def place(self, placements: Iterable[Placement], *, new_episode: bool = True) -> Sight:
        """Arrange the field while the world is paused; a new episode puts all in Start."""

    def step(self) -> Sight:
        """Let the world run for one cycle."""

    def command(self, state: str, pace: float = 0.0) -> Sequence[Example]:
        """Command the keeper.

        Args:
            state: to perform.
            pace: simulated seconds in a second of a person who is late; 0: it is in time.

        Returns:
            The examples that it added; none if it came when its episode was over.
        """

    def test(self, *, restart: bool = False) -> None:
        """Let the keeper do what it has learned."""

    def take_over(self) -> None:
        """Take control back."""

    def undo(self) -> None:
        """Undo the last command."""

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete examples."""

    def examples(self) -> Sequence[Example]:
        """Return what has been recorded in this training."""

    def retime(self, numbers: Iterable[int], ago: float) -> None:
        """Have commands been due so many seconds before they came."""

    def contradictions(self) -> int:
        """Return how many commands are asked about since they contradict others."""

    def questions(self) -> Sequence[Question]:
        """Return what the keeper asks, the most useful first."""

    def answer(self, number: int, choice: str) -> None:
        """Answer a question; "": dismiss it."""

    def save(self, *, keep_unused: bool = False) -> None:
        """Save what was trained and give it to the teammates."""

    def perform(self, behavior: str) -> None:
        """Have the teammates perform a behavior; "": nothing."""


def learner(*, sides: bool = True, ahead: bool = True) -> str:
    """Return the classifier that learns, with these aids."""
    return f"tree(all_around={not sides}, look_ahead={ahead})"


def _unmarked(example: Example, contradicted: bool) -> Example:
    """Return an example, learned from whether a command contradicts it or not."""
    return example


class InProcessPupil:
    """A team in this process: the engine's agents in a simulated world, without ROS.

    Args:
        seed: of the world and the agents.
        parameters: of the game.
        supersede: let commands outrank the default examples that they contradict.
        sides: let a command among default examples hold for a side of the circle.
        ahead: let trees look one step ahead.
        without: assistants to leave out, by name.
        world: makes the world of its parameters and seed.
        library: a folder with what the team has learned before; it stays as it is.
    """

    def __init__(
        self,
        seed: int,
        parameters: KeepawayParameters = PAPER,
        *,
        world: Callable[[KeepawayParameters, int], KeepawayWorld] = KeepawayWorld,
        library: Path | None = None,
        supersede: bool = True,
        sides: bool = True,
        ahead: bool = True,
        without: Collection[str] = (),
    ) -> None:
        self.given = 0
        self._held_before = Counter[str]()
        self._plan = ""
        # The engine has no such switch, since nobody should want it.
        setattr(example_log, "marked", marked if supersede else _unmarked)  # noqa: B010
        self._classifier = learner(sides=sides, ahead=ahead)
        self._folder = tempfile.TemporaryDirectory(prefix="hitab-teachers-")
        if library is not None:
            shutil.copytree(library, self._folder.name, dirs_exist_ok=True)
        self._world = world(parameters, seed)
        self._library = BehaviorLibrary(self._folder.name, DOMAIN)
        self.cycle_seconds = self._world.cycle_seconds
        self._agents = {
            name: Agent(name, DOMAIN, self._library, seed=seed, without=without)
            for name in self._world.agents
        }
        self._pupil, *self._mates = self._agents.values()
        self._visible = [Term.parse(name) for name in VISIBLE]

    def close(self) -> None:
        """Delete the team's library."""
        self._folder.cleanup()

    @property
    def repertoire(self) -> Repertoire:
        """What the trained keeper can do by now."""
        return self._pupil.repertoire

    def begin(self, plan: Plan, *, resume: bool = False) -> None:
        """Begin to train an automaton, or resume its training."""
        curriculum = Curriculum.parse(plan.name, plan.features, plan.states, {}, self._classifier)
        self._pupil.begin(curriculum, resume=plan.name if resume else "")
        self._plan = plan.name

    def place(self, placements: Iterable[Placement], *, new_episode: bool = True) -> Sight:
        """Arrange the field while the world is paused; a new episode puts all in Start."""
        self._world.place(placements, new_episode=new_episode)
        self._perceive(jumped=True, restart=new_episode)
        return self._sight()

    def step(self) -> Sight:
        """Let the world run for one cycle; after the last one of an episode another begins."""
        actions = {}
        self._perceive()
        for name, agent in self._agents.items():
            agent.tick()
            actions[name] = agent.body.act()
        ended = bool(self._world.step(actions))
        if ended:
            self._world.reset()
        self._perceive(restart=ended)
        return self._sight(ended=ended)

    def command(self, state: str, pace: float = 0.0) -> Sequence[Example]:
        """Command the keeper; see `Pupil.command`."""
        taught = self._pupil.command(Term.parse(state), Given(pace=pace))
        self.given += len(taught)
        return taught

    def test(self, *, restart: bool = False) -> None:
        """Let the keeper do what it has learned."""
        self._pupil.test(restart=restart)

    def take_over(self) -> None:
        """Take control back."""
        self._pupil.take_over()

    def undo(self) -> None:
        """Undo the last command."""
        self._session.undo()

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete examples."""
        self._session.delete(numbers)

    def examples(self) -> Sequence[Example]:
        """Return what has been recorded in this training."""
        return self._session.examples

    def retime(self, numbers: Iterable[int], ago: float) -> None:
        """Have commands been due so many seconds before they came."""
        self._session.retime(numbers, ago)

    def contradictions(self) -> int:
        """Return how many commands are asked about since they contradict others."""
        known = self._session.questions.known()
        return sum(question.kind is QuestionKind.CONTRADICTION for question in known)

    def questions(self) -> Sequence[Question]:
        """Return what the keeper asks, the most useful first."""
        return self._session.questions.find()

    def answer(self, number: int, choice: str) -> None:
        """Answer a question; "": dismiss it."""
        before = len(self._session.examples)
        self._session.answer(number, choice, dismiss=not choice)
        self.given += max(0, len(self._session.examples) - before)

    @property
    def lateness(self) -> float:
        """The estimated median of the person's delays, s."""
        return self._pupil.people[""].median

    @property
    def held(self) -> int:
        """Return the number of examples that all trainings hold now."""
        if self._pupil.session is not None:
            self._held_before[self._plan] = len(self._session.examples)
        return self._held_before.total()

    @property
    def _session(self) -> TrainingSession:
        session = self._pupil.session
        assert session is not None
        return session

    def save(self, *, keep_unused: bool = False) -> None:
        """Save what was trained and give it to the teammates."""
        self._held_before[self._plan] = len(self._session.examples)
        self._pupil.save(keep_unused=keep_unused)
        for mate in self._mates:
            mate.reload()

    def perform(self, behavior: str) -> None:
        """Have the teammates perform a behavior; "": nothing."""
        for mate in self._mates:
            mate.perform(Term.parse(behavior) if behavior else None)

    def _perceive(self, *, jumped: bool = False, restart: bool = False) -> None:
        world = self._world
        time = world.cycle * self.cycle_seconds
        for name, agent in self._agents.items():
            agent.sense(*world.percept(name), world.cycle, time, jumped=jumped)
            if restart:
                agent.restart(world.seed, world.episode)

    def _sight(self, *, ended: bool = False) -> Sight:
        session = self._session
        look = self._pupil.context.feature_cache.look
        values = {str(term): look(term) for term in self._visible}
        child = session.running.child
        values[DONE] = float(child is not None and "Done" in child.raised)
        below = dict(pairwise(session.running.active_path))
        return Sight(session.running.active, values, ended, below)
