"""What regression makes of moments in which one keeper was driven, beside other ways to learn.

A script drives keeper_1 in a team that is hard-coded: every half second that it should get open,
or go to the ball, it commands the direction in which hard-coded code would run, with an error as
large as a person's. The three keepers of a team then run as was learned from these moments, and
all else is hard-coded. All teams play the same episodes in one process.

    scripts/python research/continuous.py --json continuous.json
    scripts/python research/continuous.py --task meet --episodes 20

The moments are shown in other episodes than those of the figures. Each of several demonstrations
is played for its share of the episodes.
"""

from __future__ import annotations

import json as js
import math
import tempfile
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random
from statistics import fmean
from typing import Annotated, Any

import numpy as np
import typer
from scipy.stats import sem
from scipy.stats import t as student_t
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.neighbors import KNeighborsRegressor
from sklearn.neural_network import MLPRegressor

from hitab_core import Agent, Automaton, BasicBehavior, BehaviorLibrary, Domain, Repertoire, Term
from hitab_core.regression import Neighbors
from hitab_core.training import Curriculum
from hitab_world.inprocess import AutomatonPlayer, perform, play
from keepaway_world.behaviors import get_open
from keepaway_world.body import KeeperBody
from keepaway_world.features import direction_to
from keepaway_world.game.angles import wrapped
from keepaway_world.game.continuous import DIRECTION, DOMAIN, run_towards
from keepaway_world.game.interception import HORIZON, Interceptor
from keepaway_world.game.physics import Mover
from keepaway_world.parameters import PAPER
from keepaway_world.percept import BALL
from keepaway_world.world import KeepawayWorld

SHOWN_SEED, PLAYED_SEED = 52_000, 60_221
EVERY = 5  # cycles between two commands
ERROR_DEG = 10.0  # standard deviation of what the script commands
Policy = Callable[[KeeperBody], "float | None"]
"""Returns a direction relative to the body, degrees; None: stand still."""


class _Probe(KeeperBody):
    """Notes in which direction hard-coded code would go, instead of going there."""

    direction: float | None = None

    def dash(self, power: float) -> None:
        """Note whether it goes ahead."""
        self.direction = 0.0 if power > 0 else None

    def turn_by(self, angle: float) -> None:
        """Note where it turns."""
        self.direction = math.degrees(angle)


def hard_coded_open(body: KeeperBody) -> float | None:
    """Return where GetOpen would run."""
    probe = _Probe(body.name)
    probe.sense(body.values, body.heard)
    get_open(probe)
    return probe.direction


def hard_coded_meet(body: KeeperBody) -> float | None:
    """Return where a player would run to meet the ball as soon as it can, as far as it sees."""
    me, ball = Mover("me", "keeper", 1, PAPER), Mover("ball", "ball", 0, PAPER)
    (me.x, me.y), (me.vx, me.vy), me.heading = body.position, body.velocity, body.heading
    dx, dy = body.vector_to(BALL)
    ball.x, ball.y, (ball.vx, ball.vy) = me.x + dx, me.y + dy, body.ball_velocity
    planner = Interceptor(PAPER)
    track = planner.track(ball)
    cycles, _ = planner.intercept(me, track)
    x, y = track[min(cycles, HORIZON)]
    bearing = math.atan2(y - me.y - me.vy, x - me.x - me.vx)
    return math.degrees(wrapped(bearing - me.heading))


def _towards(target: str, off: float) -> Policy:
    def policy(body: KeeperBody) -> float | None:
        place = DOMAIN.targets[target].resolve(body)
        return math.degrees(direction_to(body, place)) + off

    return policy


@dataclass(frozen=True)
class Experiment:
    """What is shown.

    Attributes:
        replaces: the behavior of the hard-coded team.
        hard_coded: what the script shows.
        features: that it is learned from.
        relative_to: the target of the second way to show it, as a direction relative to that.
        rules: without any example.
    """

    replaces: str
    hard_coded: Policy
    features: tuple[str, ...]
    relative_to: str
    rules: dict[str, Policy]


EXPERIMENTS = {
    "open": Experiment(
        "GetOpen",
        hard_coded_open,
        (
            *(
                f"{f}({k}_keeper)"
                for k in ("closest", "farthest")
                for f in ("DirectionTo", "DistanceTo")
            ),
            "DirectionTo(top_left_corner)",
            "DistanceTo(top_left_corner)",
        ),
        "closest_keeper",
        {
            "0 examples: stand still": lambda body: None,
            "0 examples: away from the closest keeper": _towards("closest_keeper", 180.0),
        },
    ),
    "meet": Experiment(
        "GotoBall",
        hard_coded_meet,
        ("DirectionTo(ball)", "DistanceTo(ball)", "BallSpeed", "BallCourse"),
        "ball",
        {
            "0 examples: towards the ball": _towards("ball", 0.0),
            "0 examples: straight ahead": lambda body: 0.0,
        },
    ),
}


class Driven:
    """keeper_1 of a hard-coded team, driven by a script while it should do what is shown."""

    def __init__(
        self, shown: Experiment, relative: bool, moments: int, error: float, seed: int
    ) -> None:
        self._shown, self._left = shown, moments
        self._random, self._error = Random(seed), error
        self._word = f"RunBeside({shown.relative_to}, " if relative else "RunTowards("
        self._relative = _towards(shown.relative_to, 0.0) if relative else None
        self._hand = AutomatonPlayer(Repertoire(DOMAIN), Term("Keepaway"), "keeper_1")
        self.body = self
        folder = tempfile.TemporaryDirectory()
        self._folder = folder
        self.agent = Agent("keeper_1", DOMAIN, BehaviorLibrary(folder.name, DOMAIN))
        self.session = self.agent.begin(Curriculum.parse("Shown", shown.features, (), {}, "tree"))
        self._cycle = self._since = 0
        self._acts: Any = None

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode."""
        self._hand.begin(seed, episode)
        self.agent.restart(seed, episode)
        self._since = 0

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take a percept, for the team's code and for the training."""
        self._cycle += 1
        self._hand.body.sense(values, heard)
        self.agent.sense(values, heard, self._cycle, self._cycle / 10.0)

    def tick(self) -> None:
        """Act, as commanded or as the team."""
        self._hand.tick()
        if self._shown.replaces not in self._hand.running.active_path:
            self._since = 0
            self._acts = self._hand.body
            return
        body = self.agent.body
        if self._left and self._since % EVERY == 0:
            self._left -= 1
            self.agent.command(Term.parse(self._command(body)))
        self._since += 1
        self.agent.tick()
        self._acts = body

    def _command(self, body: KeeperBody) -> str:
        direction = self._shown.hard_coded(body)
        if direction is None:
            return "Stop"
        if self._relative is not None:
            direction -= self._relative(body) or 0.0
        direction += self._random.gauss(0.0, self._error)
        return f"{self._word}direction={(direction + 180.0) % 360.0 - 180.0:.0f})"

    def act(self) -> tuple[Sequence[float], str]:
        """Return the action."""
        return self._acts.act()

    @property
    def done(self) -> bool:
        """Whether all moments have been shown."""
        return not self._left


def drive(shown: Experiment, relative: bool, moments: int, error: float, seed: int) -> Automaton:
    """Return what is learned from moments."""
    world = KeepawayWorld(replace(PAPER, taker_speed=0.25), seed=seed)
    driven = Driven(shown, relative, moments, error, seed)
    players: dict[str, Any] = dict(perform(world, Repertoire(DOMAIN), "Keepaway"))
    players["keeper_1"] = driven
    while not driven.done:
        play(world, players, 1, cycles_max=600)
    return driven.session.automaton()


def team(shown: Experiment, automaton: Automaton) -> Domain:
    """Return the hard-coded team's domain with an automaton in the place of what it replaces."""
    behaviors = {n: b for n, b in DOMAIN.behaviors.items() if n != shown.replaces}
    automata = {**DOMAIN.automata, shown.replaces: replace(automaton, name=shown.replaces)}
    return replace(DOMAIN, behaviors=behaviors, automata=automata)


def team_of(shown: Experiment, policy: Policy) -> Domain:
    """Return the hard-coded team's domain with a policy in the place of what it replaces."""

    def pulse(body: KeeperBody) -> None:
        direction = policy(body)
        if direction is None:
            DOMAIN.behaviors["Stop"].pulse(body)
        else:
            run_towards(body, direction)

    behaviors = {**DOMAIN.behaviors, shown.replaces: BasicBehavior(shown.replaces, pulse)}
    automata = {n: a for n, a in DOMAIN.automata.items() if n != shown.replaces}
    return replace(DOMAIN, behaviors=behaviors, automata=automata)


def _encoded(rows: np.ndarray, shown: Experiment) -> np.ndarray:
    """Return features with angles as sines and cosines."""
    columns = []
    for i, feature in enumerate(shown.features):
        column = np.nan_to_num(rows[:, i])
        if DOMAIN.scale_of(Term.parse(feature)).period:
            columns += [np.sin(column), np.cos(column)]
        else:
            columns.append(column)
    return np.stack(columns, axis=1)


def clone(shown: Experiment, automaton: Automaton, learner: Any) -> Policy:
    """Return what a learner clones: a vector towards where to run, none where to stand still."""
    moments = [e for e in automaton.examples if not e.is_default]
    X = _encoded(np.array([e.features for e in moments]), shown)
    offset, scale = X.mean(axis=0), X.std(axis=0) + 1e-9
    turns = [math.radians(e.numbers[0]) if e.numbers else None for e in moments]
    y = np.array([(0.0, 0.0) if t is None else (math.cos(t), math.sin(t)) for t in turns])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        learner.fit((X - offset) / scale, y)
    still = any(t is None for t in turns)
    terms = [Term.parse(feature) for feature in shown.features]

    def policy(body: KeeperBody) -> float | None:
        values = [
            DOMAIN.features[u.name].read(
                body, *(DOMAIN.targets[a].resolve(body) for a in u.arguments)
            )
            for u in terms
        ]
        x, y = learner.predict((_encoded(np.array([values]), shown) - offset) / scale)[0]
        if still and math.hypot(x, y) < 0.5:
            return None
        return math.degrees(math.atan2(y, x))

    return policy


LEARNERS: dict[str, Callable[[], Any]] = {
    "multi-layer perceptron": lambda: MLPRegressor(
        hidden_layer_sizes=(64, 64), alpha=1e-2, max_iter=3000, random_state=1
    ),
    "nearest neighbors": lambda: KNeighborsRegressor(3, weights="distance"),
    "Gaussian process": lambda: GaussianProcessRegressor(
        ConstantKernel() * RBF() + WhiteKernel(0.1), random_state=1
    ),
}


@dataclass(frozen=True)
class Row:
    """A kind of team: for how long each demonstration's team kept the ball, s, by episode."""

    name: str
    moments: int
    seconds: list[list[float]] = field(default_factory=list)

    def __str__(self) -> str:
        """Return the mean with its 95% interval over demonstrations, or episodes if one."""
        means = [fmean(s) for s in self.seconds]
        values = means if len(means) > 1 else self.seconds[0]
        few = len(values) < 2
        half = math.inf if few else student_t.ppf(0.975, len(values) - 1) * sem(values)
        return f"{self.name:45} {self.moments:4d} moments  {fmean(means):6.2f} ± {half:5.2f} s"


def score(domain: Domain, episodes: range) -> list[float]:
    """Return for how long a team keeps the ball in each of some episodes, s."""
    world = KeepawayWorld(replace(PAPER, taker_speed=0.25), seed=PLAYED_SEED)
    players = perform(world, Repertoire(domain), "Keepaway")
    results = play(world, players, len(episodes), first=episodes.start, cycles_max=3000)
    return [result.seconds for result in results]


def teams(shown: Experiment, moments: int, seed: int) -> list[tuple[str, int, Domain]]:
    """Return the teams of one demonstration: name, number of moments, domain."""
    learned = drive(shown, False, moments, ERROR_DEG, seed)
    beside = drive(shown, True, moments, ERROR_DEG, seed)
    few = drive(shown, True, moments // 4, ERROR_DEG, seed)
    found = [
        ("hard-coded", 0, team_of(shown, shown.hard_coded)),
        ("regression, RunTowards", moments, team(shown, learned)),
        (f"regression, RunBeside({shown.relative_to})", moments, team(shown, beside)),
        (f"regression, RunBeside({shown.relative_to})", moments // 4, team(shown, few)),
        *(
            (f"cloned: {title}", moments, team_of(shown, clone(shown, learned, make())))
            for title, make in LEARNERS.items()
        ),
        *((title, 0, team_of(shown, policy)) for title, policy in shown.rules.items()),
    ]
    if shown.replaces == "GotoBall":
        found.insert(1, ("hard-coded GotoBall of the team", 0, DOMAIN))
    return found


def costs() -> list[dict[str, float]]:
    """Return what learning and one prediction cost, in time of a processor, with four features."""
    found = []
    random = np.random.default_rng(1)
    scales = [DOMAIN.scale_of(Term.parse(f)) for f in EXPERIMENTS["meet"].features]
    for moments in (100, 200, 1000, 10_000):
        X = random.uniform(-3.0, 3.0, (moments, len(scales)))
        numbers = random.uniform(-180.0, 180.0, (moments, 1))
        began = time.process_time()
        learned = Neighbors(X, numbers, scales, [DIRECTION])
        took = time.process_time() - began
        places = random.uniform(-3.0, 3.0, (2000, len(scales))).tolist()
        began = time.process_time()
        for place in places:
            learned(place)
        each = (time.process_time() - began) / len(places)
        found.append({"moments": moments, "learn_ms": 1e3 * took, "tick_us": 1e6 * each})
    return found


def run(
    task: Annotated[list[str] | None, typer.Option(help="open or meet. Default: both.")] = None,
    episodes: int = 200,
    moments: int = 200,
    demonstrations: int = 10,
    json: Path | None = None,
) -> None:
    """Show moments, learn from them in several ways, and play."""
    found: dict[str, Any] = {"costs": costs()}
    for cost in found["costs"]:
        print(
            f"{cost['moments']:6.0f} moments: learned in {cost['learn_ms']:8.2f} ms, "
            f"{cost['tick_us']:5.1f} us a tick"
        )
    share = episodes // demonstrations
    for name in task or EXPERIMENTS:
        print(f"{name}: {demonstrations} x {share} episodes of seed {PLAYED_SEED}")
        rows: dict[tuple[str, int], Row] = {}
        for number in range(demonstrations):
            for title, count, domain in teams(EXPERIMENTS[name], moments, SHOWN_SEED + number):
                seconds = score(domain, range(number * share, (number + 1) * share))
                rows.setdefault((title, count), Row(title, count)).seconds.append(seconds)
                print(f"  demonstration {number}: {title}, {fmean(seconds):.1f} s", flush=True)
            found[name] = [vars(row) for row in rows.values()]
            if json is not None:
                json.write_text(js.dumps(found, indent=1))
        print(*rows.values(), sep="\n", flush=True)


if __name__ == "__main__":
    typer.run(run)
