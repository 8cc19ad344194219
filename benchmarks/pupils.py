"""What a simulated person trains: a team of keepers in a world that runs.

`Pupil` is all that a person can see and do, as in the studio; `InProcessPupil` is a team in this
process. A person sees one keeper's percepts, cycle by cycle, after the keepers have acted on them.
A command therefore takes effect in the next cycle.
"""

from __future__ import annotations

import itertools
import math
import tempfile
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from intentions import BALL, CLOSER, DONE, KICKABLE, OFF, TAKER, YELLED, Plan

from hitab_core import Agent, BehaviorLibrary, Repertoire, Use
from hitab_core.example import Example, superseding
from hitab_core.training import example_log
from hitab_core.training.curriculum import Curriculum
from hitab_world import Placement
from keepaway_world.domain import DOMAIN
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.world import KeepawayWorld

VISIBLE = (BALL, OFF, TAKER, KICKABLE, CLOSER, YELLED)
"""Everything that an intention may depend on, besides flags."""

WHETHER = (KICKABLE, CLOSER, YELLED, DONE)
"""What is so or not so."""

SPREAD_CYCLES = 1
"""By how much a reaction time differs from its mean."""

MEMORY_CYCLES = 20
"""How many percepts an agent in training keeps."""


@dataclass(frozen=True)
class Sight:
    """What a person sees after a cycle.

    Attributes:
        state: the active state of what is being trained.
        values: of everything visible, by feature.
        ended: whether the episode has ended.
    """

    state: str
    values: Mapping[str, float]
    ended: bool


class Pupil(Protocol):
    """A team of which one keeper is trained.

    Attributes:
        cycle_seconds: simulated time of a cycle, s.
        given: the number of examples recorded so far in all trainings, deleted ones counted.
    """

    cycle_seconds: float
    given: int

    def begin(self, plan: Plan, *, resume: bool = False) -> None:
        """Begin to train an automaton, or resume its training."""

    def place(self, placements: Iterable[Placement], *, new_episode: bool = True) -> Sight:
        """Arrange the field while the world is paused; a new episode puts all in Start."""

    def step(self) -> Sight:
        """Let the world run for one cycle."""

    def command(self, state: str, ago: float = 0.0) -> Sequence[Example]:
        """Command the keeper; the command was due ``ago`` seconds earlier."""

    def test(self, *, restart: bool = False) -> None:
        """Let the keeper do what it has learned."""

    def take_over(self) -> None:
        """Take control back."""

    def undo(self) -> None:
        """Undo the last command."""

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete examples."""

    def save(self, *, keep_unused: bool = False) -> None:
        """Save what was trained and give it to the team mates."""

    def perform(self, behavior: str) -> None:
        """Have the team mates perform a behavior; "": nothing."""


class InProcessPupil:
    """A team in this process: the engine's agents in a simulated world, without ROS.

    Args:
        seed: of the world and the agents.
        parameters: of the game.
        events: take what became so near the time that a command was due as its cause. An
            experiment, not yet part of the engine.
        supersede: let commands outrank the default examples that they contradict.
    """

    def __init__(
        self,
        seed: int,
        parameters: KeepawayParameters = PAPER,
        *,
        events: bool = False,
        supersede: bool = True,
    ) -> None:
        self.given = 0
        self.events = events
        # The engine has no such switch, since nobody should want it.
        setattr(example_log, "superseding", superseding if supersede else list)  # noqa: B010
        self._time = 0.0
        self._folder = tempfile.TemporaryDirectory(prefix="hitab-teachers-")
        self._world = KeepawayWorld(parameters, seed)
        self._library = BehaviorLibrary(self._folder.name, DOMAIN)
        self.cycle_seconds = self._world.cycle_seconds
        self._agents = {
            name: Agent(name, DOMAIN, self._library, seed=seed) for name in self._world.agents
        }
        self._pupil, *self._mates = self._agents.values()
        self._visible = [Use.parse(name) for name in VISIBLE]
        self._features: deque[tuple[float, ...]] = deque(maxlen=MEMORY_CYCLES)
        self._whether: list[bool] = []
        self._circular: list[bool] = []

    def close(self) -> None:
        """Delete the team's library."""
        self._folder.cleanup()

    @property
    def repertoire(self) -> Repertoire:
        """What the trained keeper can do by now."""
        return self._pupil.repertoire

    def begin(self, plan: Plan, *, resume: bool = False) -> None:
        """Begin to train an automaton, or resume its training."""
        curriculum = Curriculum.parse(plan.name, plan.features, plan.states, (), (), "tree")
        self._pupil.begin(curriculum, resume=plan.name if resume else "")
        self._whether = [name in WHETHER for name in plan.features]
        self._circular = [name == OFF for name in plan.features]
        self._features.clear()

    def place(self, placements: Iterable[Placement], *, new_episode: bool = True) -> Sight:
        """Arrange the field while the world is paused; a new episode puts all in Start."""
        self._world.place(placements, new_episode=new_episode)
        if new_episode:
            for agent in self._agents.values():
                agent.restart(self._world.seed, self._world.episode)
        self._features.clear()
        self._perceive(jumped=True)
        return self._sight()

    def step(self) -> Sight:
        """Let the world run for one cycle."""
        actions = {}
        self._perceive()
        for name, agent in self._agents.items():
            agent.tick()
            actions[name] = agent.act()
        seen = self._sight()
        if self._world.step(actions):
            seen = Sight(seen.state, seen.values, True)
        return seen

    def command(self, state: str, ago: float = 0.0) -> Sequence[Example]:
        """Command the keeper; the command was due ``ago`` seconds earlier."""
        if ago > 0.0 and self.events:
            ago = self._event(ago)
        taught = self._pupil.command(Use.parse(state), ago=ago)
        self.given += len(taught)
        return taught

    def _event(self, ago: float) -> float:
        """Return when what the person reacted to came about, if anything did; else the same time.

        It is the first moment about a reaction time ago at which something became so or ceased to
        be so, or a value jumped.
        """
        seen = self._features
        back = round(ago / self.cycle_seconds)
        first, last = min(back + SPREAD_CYCLES, len(seen) - 2), max(back - SPREAD_CYCLES, 0)
        window = [seen[-2 - age] for age in range(first, first - 1, -1)]
        window += [seen[-1 - age] for age in range(first, last - 1, -1)]
        for place, now in enumerate(window[1:]):
            if any(a != b for a, b, w in zip(now, window[0], self._whether, strict=True) if w):
                return (first - place) * self.cycle_seconds
        for column, whether in enumerate(self._whether):
            if whether:
                continue
            steps = [
                abs(math.remainder(b[column] - a[column], 2.0 * math.pi))
                if self._circular[column]
                else abs(b[column] - a[column])
                for a, b in itertools.pairwise(window)
            ]
            if steps and max(steps) > 0.75 * sum(steps) > 0.0 and len(steps) > 1:
                return (first - steps.index(max(steps))) * self.cycle_seconds
        return ago

    def test(self, *, restart: bool = False) -> None:
        """Let the keeper do what it has learned."""
        self._pupil.test(restart=restart)

    def take_over(self) -> None:
        """Take control back."""
        self._pupil.take_over()

    def undo(self) -> None:
        """Undo the last command."""
        assert self._pupil.session is not None
        self._pupil.session.undo()

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete examples."""
        assert self._pupil.session is not None
        self._pupil.session.delete(numbers)

    def save(self, *, keep_unused: bool = False) -> None:
        """Save what was trained and give it to the team mates."""
        self._pupil.save(keep_unused=keep_unused)
        for mate in self._mates:
            mate.reload()

    def perform(self, behavior: str) -> None:
        """Have the team mates perform a behavior; "": nothing."""
        for mate in self._mates:
            mate.perform(Use.parse(behavior) if behavior else None)

    def _perceive(self, *, jumped: bool = False) -> None:
        self._time += 0.0 if jumped else self.cycle_seconds
        for name, agent in self._agents.items():
            agent.sense(*self._world.percept(name), self._world.cycle, self._time, jumped=jumped)
        session = self._pupil.session
        if session is not None:
            self._features.append(tuple(session.running.peek_features()))

    def _sight(self) -> Sight:
        session = self._pupil.session
        assert session is not None
        look = self._pupil.context.senses.look
        values = {str(use): look(use) for use in self._visible}
        child = session.running.child
        values[DONE] = float(child is not None and "Done" in child.raised)
        return Sight(session.running.active, values, bool(self._world.ended))
