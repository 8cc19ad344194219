"""A team trained in an environment that nobody here wrote, beside other ways to such a team.

The world and its words are `examples/mpe2_team.py`: three agents of mpe2's simple_spread. A script
demonstrates with one of them, as a person would who goes to the nearest landmark that no teammate
is nearer to; it takes over where what was learned does something else for two steps. What that
agent has learned is given to all three. All teams then play the same episodes in one process.

    scripts/python research/mpe2_team.py --json mpe2.json
    scripts/python research/mpe2_team.py --demonstrations 10 --episodes 50

Learners with settings get those that score best in episodes of another seed than that of the
figures; demonstrations are of a third one.
"""

from __future__ import annotations

import json as js
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import sqrt
from pathlib import Path
from random import Random
from statistics import fmean, median, stdev
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from sklearn.base import ClassifierMixin
from sklearn.exceptions import ConvergenceWarning
from sklearn.neighbors import KNeighborsClassifier
from sklearn.neural_network import MLPClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from hitab_core import (
    START,
    Automaton,
    HandWritten,
    LearningAgent,
    Repertoire,
    Use,
    automaton_as_text,
    load_domain,
    load_file,
)
from hitab_core.plain_body import PlainBody
from hitab_world import SimulationWorld
from hitab_world.inprocess import Player, PolicyPlayer, perform, play
from hitab_world.simulation import SimulationFigures

FILE = Path(__file__).resolve().parents[1] / "examples/mpe2_team.py"
WORDS: Any = load_file(FILE)
DOMAIN = load_domain(str(FILE))
GOALS = ("GoToNearest", "GoToNext", "GoToLast")  # by rank
NAME, FEATURES = "Spread", ("Lead", "LeadToNext")
SHOWN_SEED, TRIED_SEED, PLAYED_SEED = 411, 97, 20261126
BUDGET = 30  # examples
PATIENCE, CALM = 2, 10  # steps before it takes over; episodes without that, after which it ends
TRIES = 30

Percept = Sequence[float]
Choose = Callable[[Percept], int]
Play = Callable[[SimulationWorld], Mapping[str, Player]]


def world_of(seed: int) -> SimulationWorld:
    """Return the world of a run."""
    return SimulationWorld(SimulationFigures(str(FILE)), seed)


def intention(percept: Percept) -> int:
    """Return the rank of the landmark to which the demonstrator would go."""
    return next((rank for rank in range(2) if WORDS.lead(percept, rank) > 0.0), 2)


def action_of(rank: int, percept: Percept) -> int:
    """Return what an agent does that goes to a landmark."""
    return int(WORDS.go(percept, rank)[0])


class Moment(NamedTuple):
    """A step of the demonstration: what was perceived, and meant by the demonstrator."""

    percept: Percept
    rank: int


@dataclass
class Pupil:
    """Plays the agent that is trained; the demonstrator sits beside it.

    Attributes:
        agent: is trained.
        commands: moments in which the demonstrator gave a command.
        steps: moments in which the demonstrator was in control.
        took_over: whether it did so in this episode.
    """

    agent: LearningAgent
    commands: list[Moment] = field(default_factory=list)
    steps: list[Moment] = field(default_factory=list)
    took_over: bool = True
    body: PlainBody = field(default_factory=lambda: PlainBody("agent_1"))
    _state: str = ""
    _wrong: int = 0

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode."""
        self._wrong = 0

    def tick(self) -> None:
        """Let the demonstrator look and maybe command, and the agent act."""
        moment = Moment(self.body.percept, intention(self.body.percept))
        meant, command = GOALS[moment.rank], None
        self.took_over |= self._wrong >= PATIENCE
        if self.took_over:
            self.steps.append(moment)
            if meant != self._state and len(self.agent.examples) < BUDGET:
                command = meant
                self.commands.append(moment)
        self.body.action = self.agent.step(moment.percept, command)
        self._state = next(iter(self.agent.agent.active_path), "")
        self._wrong = self._wrong + 1 if self._state != meant else 0


def taught(seed: int) -> tuple[Automaton, Pupil, int]:
    """Return what was learned, who learned it, and with how many examples.

    Half of them are shown while teammates go to what is nearest to them, half in corrections while
    these do what has been learned so far.
    """
    world, pupil = world_of(seed), Pupil(LearningAgent(DOMAIN).train(NAME, FEATURES))

    def episode(repertoire: Repertoire, behavior: str) -> None:
        play(world, {**perform(world, repertoire, behavior), "agent_1": pupil})

    while len(pupil.agent.examples) < BUDGET // 2:
        episode(Repertoire(DOMAIN), GOALS[0])
    automaton, calm = pupil.agent.learn(), 0
    while calm < CALM and len(pupil.agent.examples) < BUDGET:
        pupil.took_over = False
        episode(Repertoire(DOMAIN, {NAME: automaton}), NAME)
        calm = 0 if pupil.took_over else calm + 1
        automaton = pupil.agent.learn()
    return automaton, pupil, len(pupil.agent.examples)


def random_automaton(random: Random) -> Automaton:
    """Return an automaton that compares a random feature with a random number in each state."""

    def transition() -> HandWritten:
        bound, (yes, no) = random.uniform(-1.5, 1.5), random.choices(GOALS, k=2)
        return HandWritten(lambda value: yes if value > bound else no, (random.randrange(2),))

    transitions = {state: transition() for state in (START, *GOALS)}
    return Automaton(NAME, tuple(map(Use, GOALS)), tuple(map(Use, FEATURES)), transitions)


def performing(behavior: str, automaton: Automaton | None = None) -> Play:
    """Return a team of which all do the same."""
    trained = {} if automaton is None else {automaton.name: automaton}
    return lambda world: perform(world, Repertoire(DOMAIN, trained), behavior)


def choosing(choose: Choose) -> Play:
    """Return a team of which all choose their action by a function of their percept."""

    def act(body: PlainBody) -> None:
        body.action = [choose(body.percept)]

    return lambda world: {name: PolicyPlayer(PlainBody(name), act) for name in world.agents}


def drawn(world: SimulationWorld, make: Callable[[Random], Play]) -> Mapping[str, Player]:
    """Return a team that is drawn anew for each episode."""
    return make(Random(f"{world.seed} {world.episode}"))(world)


def rewards(team: Play, episodes: int, seed: int) -> list[float]:
    """Return the reward of each episode."""
    world, found = world_of(seed), []
    for number in range(episodes):
        world.reset(number)
        found.append(play(world, team(world), first=number)[0].measures["reward"])
    return found


def learners(name: str) -> list[ClassifierMixin]:
    """Return a learner with each of its settings."""
    if name == "nearest":
        return [KNeighborsClassifier(count) for count in (1, 3)]
    layers = (((32,), 1e-2), ((32, 32), 1.0), ((64, 64), 1e-3))
    return [MLPClassifier(size, alpha=a, max_iter=500, random_state=0) for size, a in layers]


def cloned(name: str, moments: Sequence[Moment], *, words: bool = False) -> Play:
    """Return a team that imitates moments, with the settings that do best in tried episodes.

    Args:
        name: of the learner.
        moments: that it learns from.
        words: what the features say leads to a behavior, instead of percepts to an action.
    """

    def read(percept: Percept) -> Percept:
        return [WORDS.lead(percept, rank) for rank in range(2)] if words else percept

    X = np.array([read(moment.percept) for moment in moments])
    y = [m.rank if words else action_of(m.rank, m.percept) for m in moments]
    teams = []
    for learner in learners(name):
        model = make_pipeline(StandardScaler(), learner)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            model.fit(X, y)

        def choose(percept: Percept, model: Any = model) -> int:
            found = int(model.predict([read(percept)])[0])
            return action_of(found, percept) if words else found

        teams.append(choosing(choose))
    tried = [fmean(rewards(team, TRIES, TRIED_SEED)) for team in teams]
    return teams[int(np.argmax(tried))]


def shown_by_all(episodes: int) -> list[Moment]:
    """Return all that three demonstrators would do who play together."""
    moments: list[Moment] = []

    def choose(percept: Percept) -> int:
        moments.append(Moment(percept, intention(percept)))
        return action_of(moments[-1].rank, percept)

    rewards(choosing(choose), episodes, SHOWN_SEED)
    return moments


def teams(automaton: Automaton, pupil: Pupil, many: int) -> dict[str, tuple[int, Play]]:
    """Return what is compared: how many moments each has learned from, and the team."""
    given, steps = pupil.commands, pupil.steps
    found: dict[str, tuple[int, Play]] = {
        "trained": (len(given), performing(NAME, automaton)),
        "the demonstrator's rule, hard-coded": (
            0,
            choosing(lambda percept: action_of(intention(percept), percept)),
        ),
        **{f"zero examples: {goal} alone": (0, performing(goal)) for goal in GOALS},
        "zero examples: random automata of the words": (
            0,
            lambda world: drawn(world, lambda r: performing(NAME, random_automaton(r))),
        ),
        "zero examples: random actions": (
            0,
            lambda world: drawn(world, lambda r: choosing(lambda _: r.randrange(5))),
        ),
        "zero examples: no action": (0, choosing(lambda _: 0)),
    }
    for name, title in (("nearest", "nearest neighbors"), ("mlp", "MLP")):
        found |= {
            f"{title}, features to behavior": (len(given), cloned(name, given, words=True)),
            f"{title}, percept to action": (len(given), cloned(name, given)),
            f"{title}, percept to action, all steps": (len(steps), cloned(name, steps)),
        }
    if many:
        moments = shown_by_all(many)
        title = f"MLP, percept to action, {many} episodes of three demonstrators"
        found[title] = len(moments), cloned("mlp", moments)
    return found


def _with_error(values: Sequence[float]) -> str:
    return f"{fmean(values):.1f} ± {stdev(values) / sqrt(len(values)):.1f}"


def main(
    episodes: Annotated[int, typer.Option(help="Episodes of each team.", min=2)] = 200,
    demonstrations: Annotated[int, typer.Option(help="How many to learn from.", min=1)] = 1,
    many: Annotated[int, typer.Option(help="Episodes of three demonstrators to clone.")] = 300,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Compare a trained team with others; of several demonstrations, how far they differ."""
    seen: dict[str, list[list[float]]] = {}
    moments: dict[str, int] = {}
    for number in range(demonstrations):
        automaton, pupil, examples = taught(SHOWN_SEED + number)
        print(f"{examples} examples from {len(pupil.commands)} commands", flush=True)
        if demonstrations == 1:
            print(automaton_as_text(automaton), flush=True)
        for title, (count, team) in teams(automaton, pupil, many * (demonstrations == 1)).items():
            if demonstrations == 1 or count:
                moments[title] = count
                seen.setdefault(title, []).append(rewards(team, episodes, PLAYED_SEED))
    if demonstrations == 1:
        print("\n| team | moments | reward | trained minus this |\n| --- | ---: | ---: | ---: |")
        for title, (found,) in seen.items():
            less = [a - b for a, b in zip(seen["trained"][0], found, strict=True)]
            print(f"| {title} | {moments[title]} | {_with_error(found)} | {_with_error(less)} |")
    else:
        print("\n| team | worst | median | best |\n| --- | ---: | ---: | ---: |")
        for title, runs in seen.items():
            means = sorted(map(fmean, runs))
            print(f"| {title} | {means[0]:.1f} | {median(means):.1f} | {means[-1]:.1f} |")
    if json:
        Path(json).write_text(js.dumps({"moments": moments, "rewards": seen}, indent=1) + "\n")


if __name__ == "__main__":
    typer.run(main)
