"""The tasks of the scoreboard: what is taught, by which commands, and how a team is scored.

A task teaches one level of a team by lessons: robots (`RobotTask`) or a commander over robots that
have been trained before (`CaptainTask`). `learning` plays teams that have learned in other ways at
the same task.
"""

from __future__ import annotations

import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from itertools import repeat
from pathlib import Path
from random import Random
from types import MappingProxyType
from typing import Any

from peers import Command, Learner, Policy
from school import School, basic_behavior
from takeovers import Takeovers

from hitab_client.runs.shipped import shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.inprocess import Commander
from hitab_commander.kinds.kind import CommanderKind
from hitab_core import (
    START,
    Automaton,
    BehaviorLibrary,
    Domain,
    HandWritten,
    HitabError,
    Repertoire,
    Scale,
    Term,
)
from hitab_core.learning import learn_transitions
from hitab_world import World
from hitab_world.inprocess import AutomatonPlayer, Player, play_on

TRIED_SEED = 77
"""Of the episodes in which settings are tried, and of those in which teachers take over."""


@dataclass(frozen=True)
class Team:
    """What plays a task.

    Attributes:
        robots: their automata, by name.
        captain: automata of the commander or commanders; empty: robots decide for themselves.
        commands, examples: that all this was learned from.
        plain_stop: whether Stop does nothing.
        repeats: whether a one-shot behavior is performed in each cycle in which it is chosen, as
            for who knows no states.
    """

    robots: Mapping[str, Automaton]
    captain: Mapping[str, Automaton] = field(default_factory=dict)
    commands: int = 0
    examples: int = 0
    plain_stop: bool = False
    repeats: bool = False

    def domain(self, domain: Domain) -> Domain:
        """Return the robots' domain with their automata in it."""
        behaviors = dict(domain.behaviors)
        if self.plain_stop:
            behaviors["Stop"] = replace(behaviors["Stop"], pulse=lambda body: None)
        if self.repeats:
            behaviors = {n: replace(b, one_shot=False) for n, b in behaviors.items()}
        return replace(domain, behaviors=behaviors, automata=dict(self.robots))


class Task(ABC):
    """A task.

    Attributes:
        name, title: for the option and for people.
        measure: what its scores are, with the unit.
        episodes: how many make a figure.
        words: all that the taught automata read; what a peer sees.
        limits: largest value of a feature that makes a difference, by feature.
        settings: thresholds of the rules that are tried.
        drawn: between which random ones are.
        has_stop: whether what its Stop does matters.
        has_commander: whether robots have a commander.
        has_levels: whether the taught automata are more than one.
    """

    name: str
    title: str
    measure: str
    episodes: int
    words: tuple[Term, ...]
    limits: Mapping[str, float] = MappingProxyType({})
    settings: Sequence[tuple[float, ...]]
    drawn: tuple[float, float] = (0.0, 20.0)
    has_stop = False
    has_commander = False
    has_levels = True

    def __init__(self, *, quick: bool = False) -> None:
        """Make a task; a quick one has short episodes, to see whether it works."""
        self.quick = quick

    @cached_property
    def school(self) -> School:
        """The lessons, played."""
        return self._taught()

    @property
    @abstractmethod
    def domain(self) -> Domain:
        """The domain of who is taught."""

    @abstractmethod
    def _taught(self) -> School:
        """Play the lessons."""

    @abstractmethod
    def trained(self) -> Team:
        """Return the team that the lessons have trained."""

    @abstractmethod
    def without_defaults(self) -> Team:
        """Return the same, learned without default examples."""

    @abstractmethod
    def ruled(self, *numbers: float) -> Team:
        """Return a team with hand-written rules over the same words, with these thresholds."""

    def rules(self) -> Sequence[Team]:
        """Return such teams, one for each setting."""
        return [self.ruled(*numbers) for numbers in self.settings]

    def random_rules(self, random: Random) -> Team:
        """Return such a team with random thresholds, in ascending order."""
        bounds = repeat(self.drawn, len(self.settings[0]))
        return self.ruled(*sorted(random.uniform(*both) for both in bounds))

    @abstractmethod
    def with_policy(self, policy: Policy, commands: int) -> Team:
        """Return the team in which who was taught follows a policy instead."""

    @abstractmethod
    def corrected(self, learn: Learner, budget: int) -> Takeovers:
        """Let a peer play and be corrected by what the lessons have trained."""

    @abstractmethod
    def play(self, team: Team, episodes: int, seed: int, first: int = 0) -> list[float]:
        """Return the scores of some episodes."""

    def without_commander(self) -> Team:
        """Return the trained robots without their commander."""
        return replace(self.trained(), captain={})

    @property
    def commands(self) -> list[Command]:
        """The commands of the lessons that taught this level."""
        return [command for given in self.school.commands.values() for command in given]

    @property
    def budget(self) -> int:
        """The number of commands of a demonstrator who corrects in play, as many as in lessons."""
        return sum(commands for commands, _ in self.school.costs.values())

    @property
    def scales(self) -> list[Scale]:
        """How the values of the words compare."""
        return [self.domain.features[term.name].scale for term in self.words]

    @property
    def one_shot(self) -> frozenset[str]:
        """The behaviors that are performed once."""
        return frozenset(n for n, b in self.domain.behaviors.items() if b.one_shot)

    @property
    def peer_settings(self) -> dict[str, Any]:
        """What `peers.learn` needs to know of the task."""
        limits = [self.limits.get(str(term), float("inf")) for term in self.words]
        return {"scales": self.scales, "one_shot": self.one_shot, "limits": limits}


class TwinTeacher:
    """Wants what a trained behavior would do; has a body of its own, which never acts."""

    def __init__(self, repertoire: Repertoire, term: Term, name: str) -> None:
        self._twin = AutomatonPlayer(repertoire, term, name)
        self.watched: Any = None

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode."""
        self._twin.begin(seed, episode)

    def wants(self, readings: Sequence[float]) -> str:
        """Return the basic behavior that it would perform now."""
        twin, body = self._twin, self.watched
        twin.body.sense(body.values, getattr(body, "heard", ()))
        twin.tick()
        return basic_behavior(twin.running)


class OneLevelTeacher:
    """Wants what a trained automaton of one level would do, given the values that it reads."""

    def __init__(self, automaton: Automaton, words: Sequence[Term]) -> None:
        columns = [list(words).index(term) for term in automaton.features]
        self._columns = columns
        self._labels = (START, *automaton.labels)
        index = {label: i for i, label in enumerate(self._labels)}
        slots = list(range(len(columns)))
        self._decide = {
            state: function.compile(slots, index, most_probable=True)
            for state, function in automaton.transitions.items()
        }
        self._state = START
        self._draw = Random(0).random

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode."""
        self._state = START

    def wants(self, readings: Sequence[float]) -> str:
        """Return the order that it would give now."""
        values: list[float | None] = [readings[column] for column in self._columns]
        decide = self._decide.get(self._state)
        if decide is not None:
            self._state = self._labels[decide(values, lambda slot: 0.0, self._draw)]
        return self._state


class Watched:
    """A player whose episodes a teacher watches."""

    def __init__(self, player: Player, takeovers: Takeovers, teacher: Any) -> None:
        self._player, self._takeovers, self._teacher = player, takeovers, teacher
        self.body = player.body

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode."""
        self._takeovers.begin()
        self._teacher.begin(seed, episode)
        self._player.begin(seed, episode)

    def tick(self) -> None:
        """Act on the percept."""
        self._player.tick()


def play_until_over(
    world: World,
    players: Mapping[str, Player],
    takeovers: Takeovers,
    episodes: int,
    cycles: int,
    *,
    between: Callable[[], None] | None = None,
) -> None:
    """Play episodes until all commands have been given, or nothing was left to correct."""
    for episode in range(episodes):
        if takeovers.over:
            return
        world.reset(episode)
        play_on(world, players, between=between, cycles_max=cycles)


def terms(text: str) -> tuple[Term, ...]:
    """Return uses that are separated by blanks."""
    return tuple(Term.parse(part) for part in text.split())


def rule(name: str, states: str, features: str, **choose: Callable[..., str]) -> Automaton:
    """Return a hand-written automaton.

    Args:
        name: of the automaton; ``Name(A)`` has a parameter A.
        states, features: separated by blanks.
        choose: a rule by state; ``rest`` for all others.
    """
    term = Term.parse(name)
    read = terms(features)
    every = tuple(range(len(read)))
    functions = {}
    for state in (START, *states.split()):
        function = choose.get(state.split("(")[0], choose.get("rest"))
        if function is not None and state not in ("Done", "Failed"):
            functions[state] = HandWritten(function, every)
    return Automaton(term.name, terms(states), read, functions, term.arguments)


@cache
def _scratch() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="hitab-learning-")


def scratch() -> Path:
    """Return a new folder for what lessons save; it is deleted with the process."""
    return Path(tempfile.mkdtemp(dir=_scratch().name))


def library(domain: Domain, folder: Path | None = None) -> BehaviorLibrary:
    """Return a library; by default with nothing in it but what the domain brings."""
    return BehaviorLibrary(folder or Path(_scratch().name) / "nothing", domain)


def commanders(
    team: Team, kind: CommanderKind, behavior: str, groups: Mapping[str, tuple[str, ...]]
) -> list[Commander]:
    """Return the commanders of a team, by the names of their groups; none if it has none."""
    if not team.captain:
        return []
    domain = replace(commander_domain(kind), automata=dict(team.captain))
    known = library(domain)
    return [Commander(name, kind, known, behavior, group) for name, group in groups.items()]


def lesson_file(name: str) -> Path:
    """Return a lesson of the benchmarks, or a shipped one."""
    own = Path(__file__).parent / "lessons" / f"{name}.yaml"
    if own.is_file():
        return own
    try:
        return shipped("lessons", f"{name}.yaml")
    except HitabError:
        return shipped("lessons", name)


def without_defaults(automaton: Automaton, domain: Domain) -> Automaton:
    """Return an automaton as it is learned without its default examples."""
    examples = tuple(example for example in automaton.examples if not example.is_default)
    scales = [domain.scale_of(feature) for feature in automaton.features]
    return replace(automaton, examples=examples, transitions=learn_transitions(examples, scales))
