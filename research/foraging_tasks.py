"""Tasks of the scoreboard with foragers: squads that bring boxes home, and couriers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from math import hypot
from types import MappingProxyType

from peers import Command, Learner, Policy
from school import School
from takeovers import Takeovers
from tasks import (
    TRIED_SEED,
    Task,
    Team,
    TwinTeacher,
    Watched,
    commanders,
    lesson_file,
    library,
    play_until_over,
    rule,
    scratch,
    terms,
    without_defaults,
)

from foraging_world.domain import DOMAIN
from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_client.runs.shipped import shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.inprocess import Commander, HierarchyPlayers, Member
from hitab_commander.kinds.kind import CommanderKind
from hitab_commander.kinds.kind_reader import KIND_FILE, read_kind
from hitab_core import START, Automaton, Domain, HandWritten, Repertoire, Term
from hitab_world.inprocess import AutomatonPlayer, Player, play

SCHOOL = ForagingParameters(
    foragers=5,
    obstacles=0,
    small_boxes=1,
    large_boxes=1,
    noise=0.0,
    width=40.0,
    height=40.0,
    duration=100000.0,
)
"""Where foragers are taught; as in the swarm ``foraging_school``."""

GO_TO = rule(
    "GoTo(A)",
    "TurnTo(A) Forward",
    "DirectionTo(A)",
    rest=lambda d: "Forward" if abs(d) < 0.15 else "TurnTo(A)",
)


class ForagerTask(Task):
    """Foragers that are taught one after the other behavior."""

    top: str
    lessons: tuple[str, ...]
    school_world: ForagingParameters
    bindings: Mapping[str, str] = MappingProxyType({})

    @property
    def domain(self) -> Domain:
        """The foragers'."""
        return DOMAIN

    def _taught(self) -> School:
        world = ForagingWorld(self.school_world, 1)
        known = library(DOMAIN, scratch())
        hierarchy = HierarchyPlayers([Member(name, known) for name in world.agents])
        school = School(world, hierarchy, self.words, self.bindings)
        for lesson in self.lessons:
            school.play(lesson_file(lesson))
        return school

    @cached_property
    def _robots(self) -> Mapping[str, Automaton]:
        return self.school.learned("forager_1")

    def trained(self) -> Team:
        """Return the foragers of the lessons."""
        costs = self.school.costs.values()
        return Team(
            self._robots,
            commands=sum(commands for commands, _ in costs),
            examples=sum(examples for _, examples in costs),
        )

    def without_defaults(self) -> Team:
        """Return the same without default examples."""
        team = self.trained()
        robots = {name: without_defaults(a, DOMAIN) for name, a in team.robots.items()}
        count = sum(len(a.examples) for a in robots.values())
        return replace(team, robots=robots, examples=count)

    def corrected(self, learn: Learner, budget: int) -> Takeovers:
        """Let foragers play, each for itself; who trained them watches the first one."""
        words = [term.bound(self.bindings) for term in self.words]
        commanded = {command.behavior for command in self.commands}
        behaviors = sorted(str(Term.parse(b).bound(self.bindings)) for b in commanded)
        takeovers = Takeovers(learn, behaviors, budget)
        world = ForagingWorld(self._world, TRIED_SEED)
        first = world.agents[0]
        repertoire = Repertoire(replace(DOMAIN, automata=dict(self._robots)))
        teacher = TwinTeacher(repertoire, Term(self.top), first)
        players: dict[str, Player] = {}
        for name in world.agents:
            pupil = takeovers.pupil(self.top, words, teacher if name == first else None)
            domain = replace(DOMAIN, automata={self.top: pupil})
            players[name] = AutomatonPlayer(Repertoire(domain), Term(self.top), name)
        teacher.watched = players[first].body
        players[first] = Watched(players[first], takeovers, teacher)
        play_until_over(world, players, takeovers, 2 if self.quick else 10, 3000)
        names = {target: name for name, target in self.bindings.items()}
        takeovers.commands = [
            Command(
                given.readings,
                str(Term.parse(given.state).bound(names)),
                str(Term.parse(given.behavior).bound(names)),
            )
            for given in takeovers.commands
        ]
        takeovers.policy = learn(takeovers.commands)
        return takeovers

    @property
    @abstractmethod
    def _world(self) -> ForagingParameters:
        """The field that is played on."""


FORAGING_SECONDS = 150.0


class Foraging(ForagerTask):
    """Two squads of five foragers under commanders bring boxes home."""

    name = "foraging"
    title = "foraging in two squads"
    settings = ((20.0,), (45.0,), (90.0,))
    drawn = (0.0, 150.0)  # s
    measure = f"boxes brought home in {FORAGING_SECONDS:g} s"
    episodes = 10
    top = "Forage"
    lessons = ("foraging_search", "foraging_goto", "foraging_carry", "foraging_forage")
    school_world = SCHOOL
    bindings = MappingProxyType({"A": "closest_box"})
    words = terms(
        "DirectionTo(closest_obstacle) DirectionTo(A) DirectionTo(home) Sees(A) CanGrip(A) "
        "Holds(A) HoldsABox Waited Rested"
    )
    limits = MappingProxyType({"Waited": 60.0, "Rested": 60.0})
    has_commander = True

    @cached_property
    def _kind(self) -> CommanderKind:
        return read_kind(shipped("libraries", "foraging_squad") / KIND_FILE)

    @property
    def _captains(self) -> Domain:
        return commander_domain(self._kind)

    def without_defaults(self) -> Team:
        """Return foragers and their captain without default examples."""
        team = super().without_defaults()
        captain = {name: without_defaults(a, self._captains) for name, a in team.captain.items()}
        count = team.examples + sum(len(a.examples) for a in captain.values())
        return replace(team, captain=captain, examples=count)

    @property
    def _world(self) -> ForagingParameters:
        return ForagingParameters(
            foragers=10,
            small_boxes=6,
            large_boxes=0,
            obstacles=3,
            width=40.0,
            height=40.0,
            duration=5.0 if self.quick else FORAGING_SECONDS,
        )

    @cached_property
    def _squad_school(self) -> School:
        """The lesson of the squads' commander, with foragers who know how to forage."""
        world = ForagingWorld(replace(SCHOOL, noise=0.05), 1)
        known = library(replace(DOMAIN, automata=dict(self._robots)))
        own = library(self._captains, scratch())
        hierarchy = HierarchyPlayers(
            [Member(name, known) for name in world.agents],
            [Commander("squad", self._kind, own, "", world.agents)],
        )
        school = School(world, hierarchy, terms("SomeoneHolds LongestWait"))
        school.play(lesson_file("foraging_squad"))
        return school

    def trained(self) -> Team:
        """Return the foragers and commanders of the lessons."""
        team = super().trained()
        commands, examples = self._squad_school.costs["SquadForage"]
        return replace(
            team,
            captain=self._squad_school.learned("squad"),
            commands=team.commands + commands,
            examples=team.examples + examples,
        )

    def without_commander(self) -> Team:
        """Return the foragers, each for itself."""
        return super().trained()

    def ruled(self, *numbers: float) -> Team:
        """Return foragers and commanders with rules, for some wait before giving up, s."""
        return Team(forager_rules(), {"SquadForage": squad_rules(*numbers)})

    def with_policy(self, policy: Policy, commands: int) -> Team:
        """Return foragers that follow a policy, under commanders that have learned likewise."""
        carry = policy.automaton("Carry", self.words, ("A",))
        label = "Carry(closest_box)"
        forage = Automaton("Forage", terms(label), (), {START: HandWritten(lambda: label)})
        captain = self._squad_school.learned("squad")
        cost, examples = self._squad_school.costs["SquadForage"]
        return Team(
            {"Carry": carry, "Forage": forage},
            captain,
            commands + cost,
            policy.examples + examples,
        )

    def play(self, team: Team, episodes: int, seed: int, first: int = 0) -> list[float]:
        """Return how many boxes come home."""
        scores = []
        for episode in range(first, first + episodes):
            world = ForagingWorld(self._world, seed + episode)
            known = library(team.domain(DOMAIN))
            names = world.agents
            squads = {f"squad_{i + 1}": names[5 * i : 5 * i + 5] for i in range(len(names) // 5)}
            hierarchy = HierarchyPlayers(
                [Member(name, known, "Forage") for name in names],
                commanders(team, self._kind, "SquadForage", squads),
            )
            (result,) = play(world, hierarchy.players, between=hierarchy.confer)
            scores.append(result.measures["boxes"])
        return scores


def forager_rules() -> Mapping[str, Automaton]:
    """Return the foragers' automata with a rule of one line for each state."""
    made = [
        rule(
            "Search",
            "Forward RotateLeft RotateRight",
            "DirectionTo(closest_obstacle)",
            rest=lambda d: "Forward" if abs(d) > 1.6 else "RotateLeft" if d < 0 else "RotateRight",
        ),
        GO_TO,
        rule(
            "Carry(A)",
            "GoTo(A) Attach(A) GoTo(home) Release Stop",
            "Sees(A) CanGrip(A) Holds(A) HoldsABox",
            rest=lambda sees, grip, holds, any_box: (
                "GoTo(home)"
                if holds
                else "Release"
                if any_box
                else "Attach(A)"
                if grip
                else "GoTo(A)"
                if sees
                else "Stop"
            ),
        ),
        rule(
            "Forage",
            "Search Carry(closest_box) Release",
            "Sees(closest_box) HoldsABox Waited Rested",
            Release=lambda sees, holds, waited, rested: "Release" if holds else "Search",
            rest=lambda sees, holds, waited, rested: (
                "Release"
                if waited > 30.0
                else "Carry(closest_box)"
                if holds or (sees and rested > 15.0)
                else "Search"
            ),
        ),
    ]
    return {automaton.name: automaton for automaton in made}


def squad_rules(wait: float) -> Automaton:
    """Return a squad's commander with a rule of one line.

    Args:
        wait: after which a box is given up, s.
    """
    return rule(
        "SquadForage",
        "Forage Join GiveUp",
        "SomeoneHolds LongestWait",
        rest=lambda holds, waited: "GiveUp" if waited > wait else "Join" if holds else "Forage",
    )


COURIER_SECONDS = 120.0
AT_BOX, AT_HOME = 1.3, 2.0  # m from the centers
LOOK_CYCLES = 4  # how often it is looked where robots are


class Courier(ForagerTask):
    """Robots that go to and fro between a box and home, past obstacles and each other."""

    name = "courier"
    title = "couriers: to the box, home, to the box"
    settings = ((1.0,), (1.5,), (1.9,))
    measure = f"rounds of a robot in {COURIER_SECONDS:g} s"
    episodes = 12
    top = "Courier"
    lessons = ("foraging_goto", "courier")
    school_world = replace(SCHOOL, sight=100.0)
    words = terms(
        "DirectionTo(home) DistanceTo(home) DirectionTo(closest_box) DistanceTo(closest_box) "
        "CanGrip(closest_box)"
    )

    @property
    def _world(self) -> ForagingParameters:
        return ForagingParameters(
            foragers=3,
            small_boxes=1,
            large_boxes=0,
            obstacles=5,
            sight=100.0,
            width=40.0,
            height=40.0,
            duration=5.0 if self.quick else COURIER_SECONDS,
        )

    def ruled(self, *numbers: float) -> Team:
        """Return couriers with a rule for each way, for some distance from home, m."""
        return Team({"GoTo": GO_TO, "Courier": _to_and_fro(*numbers)})

    def with_policy(self, policy: Policy, commands: int) -> Team:
        """Return couriers that follow a policy."""
        courier = policy.automaton("Courier", self.words)
        return Team({"Courier": courier}, commands=commands, examples=policy.examples)

    def play(self, team: Team, episodes: int, seed: int, first: int = 0) -> list[float]:
        """Return how often a robot came home from the box, the mean of all robots."""
        repertoire = Repertoire(team.domain(DOMAIN))
        scores = []
        for episode in range(first, first + episodes):
            world = ForagingWorld(self._world, seed + episode)
            players = {
                name: AutomatonPlayer(repertoire, Term("Courier"), name) for name in world.agents
            }
            rounds, been = 0, set[str]()

            def between(world: ForagingWorld = world, been: set[str] = been) -> None:
                nonlocal rounds
                if world.episode_cycle % LOOK_CYCLES:
                    return
                things = {thing.name: thing for thing in world.entities()}
                box = things["small_box_1"]
                for name in world.agents:
                    robot = things[name]
                    if hypot(robot.x - box.x, robot.y - box.y) < AT_BOX:
                        been.add(name)
                    elif name in been and hypot(robot.x, robot.y) < AT_HOME:
                        been.discard(name)
                        rounds += 1

            play(world, players, between=between)
            scores.append(rounds / len(world.agents))
        return scores


def _to_and_fro(near: float) -> Automaton:
    """Return a courier's rules.

    Args:
        near: distance from home at which it turns back, m.
    """
    there, back = "GoTo(closest_box)", "GoTo(home)"
    return Automaton(
        "Courier",
        terms(f"{there} {back}"),
        terms("DistanceTo(home) CanGrip(closest_box)"),
        {
            START: HandWritten(lambda: there),
            there: HandWritten(lambda grip: back if grip else there, (1,)),
            back: HandWritten(lambda home: there if home < near else back, (0,)),
        },
    )
