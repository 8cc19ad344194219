"""A team of nodes, trained over topics and services as the studio does it.

`TopicPupil` is the other implementation of `pupils.Pupil`. The world is stepped cycle by cycle, so
that a person's reaction time, in simulated seconds, is the same on every machine. The same person
then teaches both pupils the same examples.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path

from hitab_msgs.msg import TransitionEvent
from intentions import DONE, Plan
from pupils import VISIBLE, Sight, learner

from hitab_bringup.libraries.opened_library import open_library
from hitab_bringup.processes.bringing_up import temporary_swarm
from hitab_client import SwarmError
from hitab_core import START, Example, Repertoire, some
from hitab_core.assistant import Question
from hitab_core.assistant.question import Choice, QuestionKind
from hitab_core.operations import (
    AnswerQuestion,
    BeginTraining,
    Command,
    DeleteExamples,
    Distribute,
    Perform,
    RetimeExamples,
    SaveBehavior,
    TakeOver,
    Test,
    Undo,
)
from hitab_ros import names, qos
from hitab_world import Placement

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from keepers import trained_keepers

PUPIL, MATES = "keeper_1", ("keeper_2", "keeper_3")
CYCLE_SECONDS = 0.1


class TopicPupil:
    """A team of three nodes and a world, started for one person.

    Args:
        seed: of the world and the agents.
    """

    cycle_seconds = CYCLE_SECONDS

    def __init__(self, seed: int) -> None:
        self.given = 0
        self._held_before = Counter[str]()
        self._plan = ""
        self._path: list[str] = []
        self._stack = ExitStack()
        swarm = trained_keepers(None, "", {}, seed=seed)
        running = self._stack.enter_context(temporary_swarm(swarm))
        self._agents, self._world, self._folder = running.agents, running.world, running.folder
        transitions = names.of_agent(PUPIL, names.TRANSITIONS)
        running.link.subscribe(TransitionEvent, transitions, self._follow, qos.EVENTS)
        running.link.spin_until(lambda: running.link.node.count_publishers(transitions) > 0, 10.0)
        self._world.state_at(0)

    def close(self) -> None:
        """Stop the nodes."""
        self._stack.close()

    @property
    def repertoire(self) -> Repertoire:
        """What the trained keeper can do by now."""
        opened = open_library(self._folder.path / "libraries" / PUPIL)
        return Repertoire(opened.domain, opened.load())

    @property
    def held(self) -> int:
        """Return the number of examples that all trainings hold now."""
        return self._held_before.total()

    # -- the world --------------------------------------------------------------------------

    def place(self, placements: Iterable[Placement], *, new_episode: bool = True) -> Sight:
        """Arrange the field while the world is paused; a new episode puts all in Start."""
        things = {
            p.name: {"x": p.x, "y": p.y, "heading": p.heading, "vx": p.vx, "vy": p.vy}
            for p in placements
        }
        self._world.shown(self._world.place(things, new_episode=new_episode))
        if new_episode:
            self._path = [START]
        return self._sight()

    def step(self) -> Sight:
        """Let the world run for one cycle."""
        before = self._world.state_at(0).episode
        after = self._world.step().episode
        if after != before:
            self._path = [START]
        return self._sight(ended=after != before)

    def _follow(self, event: TransitionEvent) -> None:
        self._path = [*event.automaton[1:], event.to_state]

    def _sight(self, *, ended: bool = False) -> Sight:
        answer = self._agents.read_features(PUPIL, VISIBLE)
        values = {r.feature: r.value for r in answer.readings if not r.automaton}
        done = [r.value for r in answer.readings if r.automaton and r.feature == DONE]
        values[DONE] = done[0] if done else 0.0
        return Sight(self._path[0], values, ended, dict(pairwise(self._path)))

    # -- training ---------------------------------------------------------------------------

    def begin(self, plan: Plan, *, resume: bool = False) -> None:
        """Begin to train an automaton, or resume its training."""
        self._agents.do(
            PUPIL,
            BeginTraining(
                plan.name,
                features=list(plan.features),
                states=list(plan.states),
                classifier=learner(),
                resume=plan.name if resume else "",
            ),
        )
        self._plan, self._path = plan.name, [START]
        self.examples()

    def command(self, state: str, pace: float = 0.0) -> Sequence[Example]:
        """Command the keeper; see `Pupil.command`."""
        self._agents.do(PUPIL, Command(state, pace=pace))
        if self._path[0] != state:
            self._path = [state]
        examples = self.examples()
        last = max(example.command for example in examples)
        taught = [example for example in examples if example.command == last]
        self.given += len(taught)
        return taught

    def test(self, *, restart: bool = False) -> None:
        """Let the keeper do what it has learned."""
        self._agents.do(PUPIL, Test(restart=restart))
        if restart:
            self._path = [START]

    def take_over(self) -> None:
        """Take control back."""
        self._agents.do(PUPIL, TakeOver())

    def undo(self) -> None:
        """Undo the last command."""
        before = self.examples()
        self._agents.do(PUPIL, Undo())
        kept = {example.number for example in self.examples()}
        gone = [example for example in before if example.number not in kept]
        if gone:
            self._path = [gone[0].state]

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete examples."""
        self._agents.do(PUPIL, DeleteExamples(list(numbers)))
        self.examples()

    def retime(self, numbers: Iterable[int], ago: float) -> None:
        """Have commands been due so many seconds before they came."""
        self._agents.do(PUPIL, RetimeExamples(list(numbers), ago))

    def examples(self) -> Sequence[Example]:
        """Return what has been recorded in this training, and note how much it holds."""
        found = self._agents.training(PUPIL).examples
        self._held_before[self._plan] = len(found)
        return found

    # -- questions --------------------------------------------------------------------------

    def contradictions(self) -> int:
        """Return how many commands are asked about since they contradict others."""
        return sum(question.kind == QuestionKind.CONTRADICTION for question in self.questions())

    def questions(self) -> Sequence[Question]:
        """Return what the keeper asks, the most useful first."""
        return [
            Question(
                q.number,
                QuestionKind(q.kind),
                q.text,
                q.state,
                tuple(Choice(c.name, "", {}) for c in q.choices),
                tuple(q.examples),
                tuple(read.value for read in q.situation),
            )
            for q in self._agents.training(PUPIL, searched=True).questions
        ]

    def answer(self, number: int, choice: str) -> None:
        """Answer a question; "": dismiss it."""
        before = len(self.examples())
        self._agents.do(PUPIL, AnswerQuestion(number, choice, dismiss=not choice))
        self.given += max(0, len(self.examples()) - before)

    # -- the team ---------------------------------------------------------------------------

    def save(self, *, keep_unused: bool = False) -> None:
        """Save what was trained and give it to the teammates."""
        self._agents.do(PUPIL, SaveBehavior(keep_unused=keep_unused))
        told = self._agents.distribute(PUPIL, Distribute(self._plan))
        if missed := [*told.refused.values(), *told.silent]:
            raise SwarmError(f"not all have it: {some(missed)}")

    def perform(self, behavior: str) -> None:
        """Have the teammates perform a behavior; "": nothing."""
        for mate in MATES:
            self._agents.do(mate, Perform(behavior))
