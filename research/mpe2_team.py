"""A team trained in an environment that nobody here wrote, beside other ways to such a team.

The world and its words are `examples/mpe2_team.py`: three agents of mpe2's simple_spread. A script
demonstrates with one of them, as a person would who goes to the nearest landmark that no teammate
is nearer to; it takes over where what was learned does something else for two steps. What that
agent has learned is given to all three. All teams then play the same episodes in one process.

    scripts/python research/mpe2_team.py --json mpe2.json --library spread
    scripts/python research/mpe2_team.py --demonstrations 10 --episodes 50

Learners with settings get those that score best in episodes of another seed than the figures'.
"""

from __future__ import annotations

import json as js
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from math import sqrt
from pathlib import Path
from random import Random
from statistics import fmean, median, stdev
from typing import Annotated, Any, NamedTuple

import typer
from peers import OPTIONS, TITLES, Command, Options, learn

from hitab_core import (
    START,
    Automaton,
    HandWritten,
    LearningAgent,
    Repertoire,
    Scale,
    Term,
    automaton_as_text,
    load_domain,
    load_file,
)
from hitab_core.plain_body import PlainBody
from hitab_world import SimulationWorld
from hitab_world.inprocess import Player, PolicyPlayer, perform, play
from hitab_world.simulating.simulation import SimulationParameters

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
    return SimulationWorld(SimulationParameters(str(FILE)), seed)


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


def taught(seed: int, library: str = "") -> tuple[Automaton, Pupil, int]:
    """Return what was learned, who learned it, and with how many examples.

    Half of them are shown while teammates go to what is nearest to them, half in corrections while
    these do what has been learned so far.
    """
    world, pupil = world_of(seed), Pupil(LearningAgent(DOMAIN, library or None))
    pupil.agent.train(NAME, FEATURES)

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
    examples = len(pupil.agent.examples)
    pupil.agent.save()
    return automaton, pupil, examples


def random_automaton(random: Random) -> Automaton:
    """Return an automaton that compares a random feature with a random number in each state."""

    def transition() -> HandWritten:
        bound, (yes, no) = random.uniform(-1.5, 1.5), random.choices(GOALS, k=2)
        return HandWritten(lambda value: yes if value > bound else no, (random.randrange(2),))

    transitions = {state: transition() for state in (START, *GOALS)}
    return Automaton(NAME, tuple(map(Term, GOALS)), tuple(map(Term, FEATURES)), transitions)


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


def cloned(name: str, moments: Sequence[Moment], *, words: bool = False) -> Play:
    """Return a team that imitates moments, with the settings that do best in tried episodes.

    Args:
        name: of a learner, see `peers.OPTIONS`.
        moments: that it learns from.
        words: it learns which behavior the features call for, not which action the percept does.
    """

    def read(percept: Percept) -> Percept:
        return [WORDS.lead(percept, rank) for rank in range(2)] if words else percept

    def team(options: Options) -> Play:
        shown = [m.rank if words else action_of(m.rank, m.percept) for m in moments]
        commands = [
            Command(tuple(read(moment.percept)), START, str(label))
            for moment, label in zip(moments, shown, strict=True)
        ]
        policy = learn(name, commands, [Scale()] * len(commands[0].readings), options=options)

        def choose(percept: Percept) -> int:
            found = int(policy(read(percept), START))
            return action_of(found, percept) if words else found

        return choosing(choose)

    made = [team(options) for options in OPTIONS[name]]
    return max(made, key=lambda team: fmean(rewards(team, TRIES, TRIED_SEED)))


def shown_by_all(episodes: int) -> list[Moment]:
    """Return all that three demonstrators would do who play together."""
    moments: list[Moment] = []

    def choose(percept: Percept) -> int:
        moments.append(Moment(percept, intention(percept)))
        return action_of(moments[-1].rank, percept)

    rewards(choosing(choose), episodes, SHOWN_SEED)
    return moments


def teams(automaton: Automaton, pupil: Pupil, many: int) -> Iterator[tuple[str, int, Play]]:
    """Yield what is compared: its title, how many moments it has learned from, and the team."""
    given, steps = pupil.commands, pupil.steps
    yield "trained", len(given), performing(NAME, automaton)
    for name in ("nearest", "mlp"):
        title = TITLES[name]
        yield f"{title}, features to behavior", len(given), cloned(name, given, words=True)
        yield f"{title}, percept to action", len(given), cloned(name, given)
        yield f"{title}, percept to action, all steps", len(steps), cloned(name, steps)
    if many:
        moments = shown_by_all(many)
        title = f"{TITLES['mlp']}, percept to action, {many} episodes of three demonstrators"
        yield title, len(moments), cloned("mlp", moments)


def unlearned() -> Iterator[tuple[str, int, Play]]:
    """Yield teams that have learned from nothing, as `teams` does."""
    rule = choosing(lambda percept: action_of(intention(percept), percept))
    yield "zero examples: the demonstrator's rule, hard-coded", 0, rule
    for goal in GOALS:
        yield f"zero examples: {goal} alone", 0, performing(goal)
    drawings: dict[str, Callable[[Random], Play]] = {
        "automata of the words": lambda random: performing(NAME, random_automaton(random)),
        "actions": lambda random: choosing(lambda _: random.randrange(5)),
    }
    for what, make in drawings.items():
        yield f"zero examples: random {what}", 0, partial(drawn, make=make)
    yield "zero examples: no action", 0, choosing(lambda _: 0)


def _with_error(values: Sequence[float]) -> str:
    return f"{fmean(values):.1f} ± {stdev(values) / sqrt(len(values)):.1f}"


def main(
    episodes: Annotated[int, typer.Option(help="Episodes of each team.", min=2)] = 200,
    demonstrations: Annotated[int, typer.Option(help="How many to learn from.", min=1)] = 1,
    many: Annotated[int, typer.Option(help="Episodes of three demonstrators to clone.")] = 100,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    library: Annotated[str, typer.Option(help="Folder for the behavior of one.")] = "",
) -> None:
    """Compare a trained team with others; of several demonstrations, how far they differ."""
    found: dict[str, list[list[float]]] = {}
    for number in range(demonstrations):
        automaton, pupil, examples = taught(SHOWN_SEED + number, library)
        print(f"{examples} examples from {len(pupil.commands)} commands", flush=True)
        compared = teams(automaton, pupil, many * (demonstrations == 1))
        if demonstrations == 1:
            print(automaton_as_text(automaton, trees=False))
            print("| team | moments | reward | trained minus this |\n| --- | ---: | ---: | ---: |")
            compared = chain(compared, unlearned())
        for title, moments, team in compared:
            got = rewards(team, episodes, PLAYED_SEED)
            found.setdefault(title, []).append(got)
            if demonstrations == 1:
                less = [a - b for a, b in zip(found["trained"][0], got, strict=True)]
                row = f"| {title} | {moments} | {_with_error(got)} | {_with_error(less)} |"
                print(row, flush=True)
    if demonstrations > 1:
        print("| team | worst | median | best |\n| --- | ---: | ---: | ---: |")
        for title, runs in found.items():
            means = sorted(map(fmean, runs))
            print(f"| {title} | {means[0]:.1f} | {median(means):.1f} | {means[-1]:.1f} |")
    if json:
        Path(json).write_text(js.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
