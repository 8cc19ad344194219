"""Tasks of the scoreboard with keepers: keepaway, a captain over it, and a captain's drill."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from peers import Learner, Policy
from school import School
from takeovers import Takeovers
from tasks import (
    TRIED_SEED,
    OneLevelTeacher,
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

from hitab_client.runs.shipped import shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.inprocess import Commander, HierarchyPlayers, Member
from hitab_commander.kinds.kind import CommanderKind
from hitab_commander.kinds.kind_reader import KIND_FILE, described_kind, read_kind
from hitab_core import Automaton, Domain, Repertoire, Term
from hitab_world.inprocess import AutomatonPlayer, Player, perform, play
from keepaway_world.domain import DOMAIN
from keepaway_world.parameters import PAPER
from keepaway_world.world import KeepawayWorld

LONGEST, QUICK = 6000, 60  # cycles: longer episodes are cut off
LESSONS = ("approach_ball", "goto_ball", "control_ball", "keepaway")


class Keepaway(Task):
    """Keepers against slow takers, by the paper's four automata."""

    name = "keepaway"
    title = "keepaway, 3 against 2"
    measure = "hold time, s"
    episodes = 100
    words = terms(
        "DistanceTo(ball) DirectionTo(ball) DistanceTo(closest_taker) BallIsKickable "
        "ATeammateIsCloserToBall IWasYelledAt"
    )
    settings = ((1.5,), (2.5,), (4.0,), (6.0,))
    drawn = (0.0, 10.0)  # m
    has_stop = True

    @property
    def _longest(self) -> int:
        return QUICK if self.quick else LONGEST

    @property
    def domain(self) -> Domain:
        """The keepers'."""
        return DOMAIN

    def _taught(self) -> School:
        world = KeepawayWorld(PAPER, 1)
        known = library(DOMAIN, scratch())
        school = School(
            world, HierarchyPlayers([Member(name, known) for name in world.agents]), self.words
        )
        for lesson in LESSONS:
            school.play(lesson_file(lesson))
        return school

    def trained(self) -> Team:
        """Return the keepers of the four lessons."""
        costs = self.school.costs.values()
        return Team(
            self.school.learned("keeper_1"),
            commands=sum(commands for commands, _ in costs),
            examples=sum(examples for _, examples in costs),
        )

    def without_defaults(self) -> Team:
        """Return the same without default examples."""
        team = self.trained()
        robots = {name: without_defaults(a, DOMAIN) for name, a in team.robots.items()}
        return replace(team, robots=robots, examples=sum(len(a.examples) for a in robots.values()))

    def ruled(self, *numbers: float) -> Team:
        """Return keepers that hold the ball until a taker is within some distance, m."""
        return Team(keeper_rules(*numbers))

    def with_policy(self, policy: Policy, commands: int) -> Team:
        """Return keepers that follow a policy."""
        keepaway = policy.automaton("Keepaway", self.words)
        return Team(
            {"Keepaway": keepaway},
            commands=commands,
            examples=policy.examples,
            repeats=not policy.knows_states,
        )

    def corrected(self, learn: Learner, budget: int) -> Takeovers:
        """Let keepers play; who trained them watches the first one."""
        behaviors = sorted({command.behavior for command in self.commands})
        takeovers = Takeovers(learn, behaviors, budget)
        world = KeepawayWorld(PAPER, TRIED_SEED)
        teacher = TwinTeacher(
            Repertoire(self.trained().domain(DOMAIN)), Term("Keepaway"), "keeper_1"
        )
        players: dict[str, Player] = {}
        for name in world.agents:
            watcher = teacher if name == "keeper_1" else None
            pupil = takeovers.pupil("Keepaway", self.words, watcher)
            domain = Team({"Keepaway": pupil}, repeats=not learn.knows_states).domain(DOMAIN)
            players[name] = AutomatonPlayer(Repertoire(domain), Term("Keepaway"), name)
        teacher.watched = players["keeper_1"].body
        players["keeper_1"] = Watched(players["keeper_1"], takeovers, teacher)
        play_until_over(world, players, takeovers, *practice(self))
        return takeovers

    def play(self, team: Team, episodes: int, seed: int, first: int = 0) -> list[float]:
        """Return how long the keepers keep the ball, s."""
        world = KeepawayWorld(PAPER, seed)
        players = perform(world, Repertoire(team.domain(DOMAIN)), "Keepaway")
        results = play(world, players, episodes, first=first, cycles_max=self._longest)
        return [result.seconds for result in results]


def practice(task: Task) -> tuple[int, int]:
    """Return how many episodes of how many cycles a demonstrator watches at most."""
    return (1, QUICK) if task.quick else (40, 600)


def keeper_rules(near: float) -> Mapping[str, Automaton]:
    """Return the keepers' automata with a rule of one line for each.

    Args:
        near: distance of the closest taker at which the ball is passed, m.
    """
    made = [
        rule(
            "ApproachBall",
            "GoFast GoMedium GoSlow Stop",
            "DistanceTo(ball)",
            rest=lambda d: (
                "Stop" if d < 1.05 else "GoSlow" if d < 2.5 else "GoMedium" if d < 5 else "GoFast"
            ),
        ),
        rule(
            "GotoBall",
            "TurnToBall ApproachBall",
            "DirectionTo(ball)",
            rest=lambda d: "ApproachBall" if abs(d) < math.radians(9) else "TurnToBall",
        ),
        rule(
            "ControlBall",
            "GotoBall Stop Pass Done",
            "DistanceTo(closest_taker) BallIsKickable",
            Pass=lambda taker, ball: "Done",
            rest=lambda taker, ball: (
                "GotoBall" if not ball else "Pass" if taker < near else "Stop"
            ),
        ),
        rule(
            "Keepaway",
            "ControlBall GetOpen",
            "ATeammateIsCloserToBall IWasYelledAt Done",
            Start=lambda closer, yelled, done: "GetOpen" if closer else "ControlBall",
            ControlBall=lambda closer, yelled, done: "GetOpen" if done else "ControlBall",
            GetOpen=lambda closer, yelled, done: "ControlBall" if yelled else "GetOpen",
        ),
    ]
    return {automaton.name: automaton for automaton in made}


class CaptainTask(Task):
    """A captain over keepers that have been trained before; only the captain is taught."""

    behavior: str
    kind: CommanderKind
    lesson: str
    has_commander = True
    has_levels = False  # its behaviors are orders: its automaton is flat
    has_stop = True

    @property
    def domain(self) -> Domain:
        """The captain's."""
        return commander_domain(self.kind)

    def _taught(self) -> School:
        world = KeepawayWorld(PAPER, 1)
        known, own = library(DOMAIN, scratch()), library(self.domain, scratch())
        hierarchy = HierarchyPlayers(
            [Member(name, known) for name in world.agents],
            [Commander("captain", self.kind, own, "", world.agents)],
        )
        school = School(world, hierarchy, self.words)
        for lesson in (*LESSONS, "captain/freeze.yaml", "captain/regroup.yaml"):
            school.play(lesson_file(lesson))
        school.commands.clear()  # only the captain's count: the keepers are the same in all teams
        school.costs.clear()
        school.play(lesson_file(self.lesson))
        return school

    @cached_property
    def _keepers(self) -> Mapping[str, Automaton]:
        return self.school.learned("keeper_1")

    def _team(self, captain: Automaton, commands: int = 0, examples: int = 0) -> Team:
        return Team(self._keepers, {captain.name: captain}, commands, examples)

    def trained(self) -> Team:
        """Return the trained captain and its keepers."""
        return self._team(
            self.school.learned("captain")[self.behavior], *self.school.costs[self.behavior]
        )

    def without_defaults(self) -> Team:
        """Return the same captain without default examples."""
        team = self.trained()
        captain = without_defaults(team.captain[self.behavior], self.domain)
        return self._team(captain, team.commands, len(captain.examples))

    def without_commander(self) -> Team:
        """Return the keepers, who were not taught here, each for itself."""
        return Team(self._keepers)

    def with_policy(self, policy: Policy, commands: int) -> Team:
        """Return a captain that follows a policy."""
        return self._team(policy.automaton(self.behavior, self.words), commands, policy.examples)

    def corrected(self, learn: Learner, budget: int) -> Takeovers:
        """Let a captain play; who trained it watches."""
        takeovers = Takeovers(learn, sorted(self.domain.behaviors), budget)
        teacher = OneLevelTeacher(self.trained().captain[self.behavior], self.words)
        team = self._team(takeovers.pupil(self.behavior, self.words, teacher))
        world = self._world(TRIED_SEED)
        hierarchy = self._hierarchy(team, world)
        players: dict[str, Player] = dict(hierarchy.players)
        players["keeper_1"] = Watched(players["keeper_1"], takeovers, teacher)
        play_until_over(world, players, takeovers, *practice(self), between=hierarchy.confer)
        return takeovers

    def _world(self, seed: int) -> KeepawayWorld:
        return KeepawayWorld(PAPER, seed)

    def _hierarchy(self, team: Team, world: KeepawayWorld) -> HierarchyPlayers:
        known = library(team.domain(DOMAIN))
        first = "" if team.captain else "Keepaway"
        return HierarchyPlayers(
            [Member(name, known, first) for name in world.agents],
            commanders(team, self.kind, self.behavior, {"captain": world.agents}),
        )


class Captain(CaptainTask):
    """The shipped captain: Freeze, Regroup or Keepaway."""

    name = "captain"
    title = "a captain over keepaway"
    measure = "hold time, s"
    episodes = 60
    behavior = "Captain"
    lesson = "captain/captain.yaml"
    words = terms("BallDistance TakerDistance")
    settings = ((4.0,), (8.0,), (12.0,))

    @property
    def _longest(self) -> int:
        return QUICK if self.quick else LONGEST

    @cached_property
    def kind(self) -> CommanderKind:  # type: ignore[override]
        """The shipped one."""
        return read_kind(shipped("libraries", "captain") / KIND_FILE)

    def ruled(self, *numbers: float) -> Team:
        """Return a captain with one rule, for some distance of takers, m."""
        (near,) = numbers
        captain = rule(
            "Captain",
            "Freeze Keepaway Regroup",
            "BallDistance TakerDistance",
            rest=lambda ball, taker: (
                "Regroup" if ball > 8 else "Keepaway" if taker < near else "Freeze"
            ),
        )
        return self._team(captain)

    def play(self, team: Team, episodes: int, seed: int, first: int = 0) -> list[float]:
        """Return how long the keepers keep the ball, s."""
        world = self._world(seed)
        hierarchy = self._hierarchy(team, world)
        results = play(
            world,
            hierarchy.players,
            episodes,
            between=hierarchy.confer,
            first=first,
            cycles_max=self._longest,
        )
        return [result.seconds for result in results]


DRILL_SECONDS = 60.0
TOGETHER, WIDE = 4.0, 6.0  # m: mean distance of the keepers from their middle


class Drill(CaptainTask):
    """A captain has its keepers come together and spread out, in turns."""

    name = "drill"
    title = "a captain's drill: together, apart, together"
    measure = f"rounds in {DRILL_SECONDS:g} s"
    episodes = 20
    behavior = "Drill"
    lesson = "drill"
    words = terms("Apart")
    settings = ((3.0, 7.0), (3.5, 6.5), (3.9, 6.1))
    drawn = (0.0, 10.0)  # m
    has_stop = False

    @cached_property
    def kind(self) -> CommanderKind:  # type: ignore[override]
        """Orders to gather around the ball and to spread out."""
        described = {
            "orders": {"Gather": "Regroup", "Spread": "GetOpen"},
            "features": {"Apart": {"group": "spread"}},
            "report_period": 0.1,
        }
        return described_kind("DrillCaptain", described)

    def ruled(self, *numbers: float) -> Team:
        """Return a captain with one rule for each order, for two distances, m."""
        together, wide = numbers
        captain = rule(
            "Drill",
            "Gather Spread",
            "Apart",
            Start=lambda apart: "Gather",
            Gather=lambda apart: "Spread" if apart < together else "Gather",
            Spread=lambda apart: "Gather" if apart > wide else "Spread",
        )
        return self._team(captain)

    def _world(self, seed: int) -> KeepawayWorld:
        # Without takers the ball lies still, for which the referee would move all players away.
        return KeepawayWorld(replace(PAPER, takers=0, stuck_area=0.0), seed)

    def play(self, team: Team, episodes: int, seed: int, first: int = 0) -> list[float]:
        """Return how often the keepers came together after they had been wide apart."""
        world = self._world(seed)
        hierarchy = self._hierarchy(team, world)
        cycles = QUICK if self.quick else round(DRILL_SECONDS / world.cycle_seconds)
        rounds, wide = 0, False

        def between() -> None:
            nonlocal rounds, wide
            hierarchy.confer()
            apart = mean_distance([(k.x, k.y) for k in world.entities() if k.kind == "keeper"])
            if wide and apart < TOGETHER:
                rounds, wide = rounds + 1, False
            wide = wide or apart > WIDE

        scores = []
        for episode in range(first, first + episodes):
            rounds, wide = 0, False
            play(world, hierarchy.players, between=between, first=episode, cycles_max=cycles)
            scores.append(float(rounds))
        return scores


def mean_distance(places: Sequence[tuple[float, float]]) -> float:
    """Return the root mean square distance of places from their middle, m."""
    x = sum(place[0] for place in places) / len(places)
    y = sum(place[1] for place in places) / len(places)
    squares = sum((px - x) ** 2 + (py - y) ** 2 for px, py in places)
    return math.sqrt(squares / len(places))
