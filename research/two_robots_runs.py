"""Runs of two robots under a captain in ir-sim: in one process, or with processes over topics.

Each seed has obstacles and start poses of its own. In one process there are ir-sim, the messages
that its bridge would publish, and the engine's agents and commander. `two_robots` is the command.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import yaml
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from std_msgs.msg import Bool
from tasks import library, rule, terms

from hitab_bringup import read_swarm, temporary_swarm
from hitab_client import RosLink
from hitab_commander import KIND_FILE, read_kind
from hitab_commander.commander_domain import commander_domain
from hitab_commander.inprocess import Commander, HierarchyPlayers, Member
from hitab_core import START, Automaton, Domain, HandWritten, HitabError
from hitab_robots import Mount
from hitab_ros.messages.stamps import seconds_of

EXAMPLE = Path(__file__).resolve().parents[1] / "examples/irsim_robots"
sys.path.insert(0, str(EXAMPLE))

from irsim_robots import room  # noqa: E402
from irsim_robots.bridge import as_time, odometry_of, scan_of, simulation  # noqa: E402
from irsim_robots.domain import DOMAIN  # noqa: E402
from irsim_robots.room import HULL, WAYPOINTS  # noqa: E402

ROBOTS = ("robot_1", "robot_2")
DUTY = "Duty"
"""What the captain performs."""
THERE = 0.5  # m: from a place that a robot has reached
STEP = 0.2  # s
HANGING_S = 120.0
"""How long the simulation may take for a second, s of this machine's clock."""

Tell = Callable[[float], None]
"""Called with the simulated time that has passed, s."""


@dataclass
class Outcome:
    """What one robot did in one run.

    Attributes:
        collided: when the simulator first said that it had, s; None: never.
        visits: the places that it came to, each once until it came to another.
        track: where it was, m, in each step.
    """

    collided: float | None = None
    visits: list[str] = field(default_factory=list)
    track: list[tuple[float, float]] = field(default_factory=list)

    def see(self, at: tuple[float, float]) -> None:
        """Take where the robot is, m."""
        self.track.append(at)
        for place, where in WAYPOINTS.items():
            if math.dist(at, where) < THERE and self.visits[-1:] != [place]:
                self.visits.append(place)

    def collide(self, seconds: float) -> None:
        """Take that the simulator says that it has collided."""
        if self.collided is None:
            self.collided = seconds


# -- in one process -------------------------------------------------------------------------


def robot_rules() -> tuple[Automaton, ...]:
    """Return the robots' automata with a rule of one line for each."""
    near = 0.5  # m
    order = [f"GoTo({place})" for place in WAYPOINTS]
    after = dict(zip(order, [*order[1:], "Done"], strict=True))
    patrol: dict[str, HandWritten] = {START: HandWritten(lambda: order[0])}
    for this, following in after.items():
        patrol[this] = HandWritten(
            lambda done, this=this, following=following: following if done else this, (0,)
        )
    return (
        rule(
            "Wander",
            "Forward TurnLeft",
            "RangeAhead",
            rest=lambda ahead: "Forward" if ahead > near else "TurnLeft",
        ),
        rule(
            "Steer(X)",
            "Forward TurnLeft TurnRight",
            "HeadingTo(X)",
            rest=lambda h: "Forward" if abs(h) < 0.2 else "TurnLeft" if h > 0 else "TurnRight",
        ),
        rule(
            "GoAround",
            "Wander Done",
            "RangeBeside",
            rest=lambda beside: "Wander" if beside < near + HULL else "Done",
        ),
        rule(
            "GoTo(X)",
            "Steer(X) GoAround Done",
            "RangeAhead DistanceTo(X) Done",
            GoAround=lambda ahead, distance, done: "Steer(X)" if done else "GoAround",
            rest=lambda ahead, distance, done: (
                "GoAround" if ahead < near else "Done" if distance < 0.4 else "Steer(X)"
            ),
        ),
        Automaton("Patrol", terms(" ".join([*order, "Done"])), terms("Done"), patrol),
    )


def captain_rule() -> Automaton:
    """Return the captain's automaton with a rule of one line for each state."""
    return rule(
        DUTY,
        "Patrol Wander",
        "AllDone Spread",
        Wander=lambda done, spread: "Patrol" if spread > 2.0 else "Wander",
        rest=lambda done, spread: "Wander" if done else "Patrol",
    )


def hierarchy(which: str) -> HierarchyPlayers:
    """Return the robots and their captain, who begin their duty.

    Args:
        which: ``trained``, ``rules``, or ``alone``: the trained robots, which patrol unordered.
    """
    libraries = EXAMPLE / "libraries"
    kind = read_kind(libraries / "captain" / KIND_FILE)
    captains = commander_domain(kind)
    if which == "rules":
        robots = library(_with(DOMAIN, robot_rules()))
        own = library(_with(captains, (captain_rule(),)))
    else:
        robots, own = (
            library(domain, libraries / name)
            for name, domain in (("robot", DOMAIN), ("captain", captains))
        )
    if which == "alone":
        return HierarchyPlayers([Member(name, robots, "Patrol") for name in ROBOTS], (), STEP)
    return HierarchyPlayers(
        [Member(name, robots) for name in ROBOTS],
        [Commander("captain", kind, own, DUTY, ROBOTS)],
        STEP,
    )


def _with(domain: Domain, automata: Sequence[Automaton]) -> Domain:
    return replace(domain, automata={automaton.name: automaton for automaton in automata})


def play(which: str, seed: int, seconds: float, yaw: float, tell: Tell) -> dict[str, Outcome]:
    """Play one run in this process, and return what each robot did."""
    world = simulation(room.room(seed, len(ROBOTS), STEP, yaw))
    bodies = dict(zip(ROBOTS, world.robot_list, strict=True))
    team = hierarchy(which)
    outcomes = {name: Outcome() for name in ROBOTS}
    commands = [np.zeros((2, 1)) for _ in ROBOTS]
    mount = Mount(yaw=yaw)
    for player in team.players.values():
        player.begin(seed, 0)
    for step in range(1, round(seconds / STEP) + 1):
        world.step(commands)
        stamp = as_time(round(step * STEP * 1e9))
        for name, player in team.players.items():
            messages = {
                "odom": odometry_of(bodies[name], name, stamp),
                "scan": scan_of(bodies[name], name, stamp),
            }
            percept = [step * STEP]
            for sensor in DOMAIN.body.sensors:
                percept += sensor.read(messages[sensor.name], mount)
            player.sense(percept, ())
            outcomes[name].see((percept[1], percept[2]))
            if bodies[name].collision:
                outcomes[name].collide(step * STEP)
        team.confer()
        commands = []
        for player in team.players.values():
            player.tick()
            velocity, _ = player.act()
            ahead, _, turn = velocity or (0.0, 0.0, 0.0)
            commands.append(np.array([[ahead], [turn]]))
        if step % 50 == 0:
            tell(step * STEP)
    return outcomes


# -- over topics ----------------------------------------------------------------------------


class Judge:
    """Sees what the simulator says on its topics, from when all robots act."""

    def __init__(self, link: RosLink) -> None:
        self.outcomes = {name: Outcome() for name in ROBOTS}
        self.now = 0.0
        self._began = math.inf
        for name, outcome in self.outcomes.items():

            def see(odometry: Odometry, outcome: Outcome = outcome) -> None:
                self.now = seconds_of(odometry.header.stamp)
                if self.seconds >= 0.0:
                    at = odometry.pose.pose.position
                    outcome.see((at.x, at.y))

            def collide(collision: Bool, outcome: Outcome = outcome) -> None:
                if collision.data:
                    outcome.collide(max(0.0, self.seconds))

            link.subscribe(Odometry, f"/{name}/odom", see, QoSProfile(depth=1000))
            link.subscribe(Bool, f"/{name}/collision", collide, QoSProfile(depth=1000))

    @property
    def seconds(self) -> float:
        """For how long they have been judged, s of simulated time."""
        return self.now - self._began

    def begin(self) -> None:
        """Judge from now on."""
        self._began = self.now

    def sees_more(self, link: RosLink) -> bool:
        """Look on for a second of simulated time; return whether it has passed."""
        end = self.now + 1.0
        return link.spin_until(lambda: self.now >= end, HANGING_S)


def description(seed: int, yaw: float, folder: Path) -> Path:
    """Write the description of the swarm for one run, and return where it is."""
    swarm = yaml.safe_load((EXAMPLE / "swarm.yaml").read_text(encoding="utf-8"))
    for part in (swarm, swarm["commanders"]["captain"]):
        part["start_from"] = str(EXAMPLE / part["start_from"])
    swarm["parameters"]["scan.yaw"] = yaw
    swarm["processes"]["irsim"]["parameters"] |= {
        "seed": seed,
        "step": STEP,
        "scanner_yaw": yaw,
        "real_time_factor": 0.0,
    }
    path = folder / "swarm.yaml"
    path.write_text(yaml.safe_dump(swarm, sort_keys=False), encoding="utf-8")
    return path


def play_over_topics(seed: int, seconds: float, yaw: float, tell: Tell) -> dict[str, Outcome]:
    """Play one run of the trained robots with processes, and return what each robot did.

    Raises:
        HitabError: if the robots do not begin, or the simulation stands still.
    """
    with (
        tempfile.TemporaryDirectory() as folder,
        temporary_swarm(read_swarm(description(seed, yaw, Path(folder)))) as swarm,
    ):
        judge = Judge(swarm.link)

        def all_begin() -> bool:
            statuses = [swarm.agents.statuses.get(name) for name in ROBOTS]
            return judge.now > 0.0 and all(s is not None and s.active_path for s in statuses)

        if not swarm.link.spin_until(all_begin, HANGING_S):
            raise HitabError(f"seed {seed}: the robots do not begin; is `irsim` installed?")
        judge.begin()
        while judge.seconds < seconds:
            if not judge.sees_more(swarm.link):
                raise HitabError(f"seed {seed}: ir-sim stands still at {judge.seconds:.0f} s")
            tell(judge.seconds)
        return judge.outcomes
