"""Robots in ir-sim, examples/irsim_robots: what holds without the simulator, and a run with it."""

import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_msgs.msg import LaserScan

from hitab_bringup import parse_swarm
from hitab_commander import KIND_FILE, read_kind
from hitab_commander.commander_domain import commander_domain
from hitab_core import Automaton, BehaviorLibrary, Repertoire, Use
from hitab_core.domain import load_domain
from hitab_robots import Mount
from hitab_world.inprocess import AutomatonPlayer

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "examples/irsim_robots"
LIBRARIES = EXAMPLE / "libraries"
sys.path.insert(0, str(EXAMPLE))
BEAMS = 72


def trained(folder: str) -> dict[str, Automaton]:
    """Return what the robots or the captain have learned, learned again from the examples."""
    if folder == "robot":
        domain = load_domain("irsim_robots.domain:DOMAIN")
    else:
        domain = commander_domain(read_kind(LIBRARIES / folder / KIND_FILE))
    return dict(BehaviorLibrary(LIBRARIES / folder, domain).load())


@pytest.mark.parametrize("name", ["school.yaml", "swarm.yaml"])
def test_the_swarms_are_of_two_robots_under_a_captain(name):
    path = EXAMPLE / name
    # Installed, its domain has a name; here it is where it is.
    text = path.read_text(encoding="utf-8").replace(
        "domain: irsim\n", "domain: irsim_robots.domain:DOMAIN\n"
    )
    swarm = parse_swarm(text, path)
    assert [agent.name for agent in swarm.agents] == ["robot_1", "robot_2"]
    (captain,) = swarm.commanders
    assert captain.kind == read_kind(LIBRARIES / "captain" / KIND_FILE)


near = st.floats(0.2, 6.0)
percepts = st.tuples(
    near, near, st.floats(0.5, 8.5), st.floats(0.5, 6.5), st.floats(-math.pi, math.pi)
)


@settings(deadline=None, max_examples=40)
@given(st.lists(percepts, min_size=1, max_size=60))
def test_the_trained_robots_do_not_drive_at_what_is_near_whatever_they_do(seen):
    domain = load_domain("irsim_robots.domain:DOMAIN")
    repertoire = Repertoire(replace(domain, automata=trained("robot")))
    player = AutomatonPlayer(repertoire, Use("Patrol"), "robot_1")
    player.begin(1, 0)
    for i, (ahead, beside, x, y, heading) in enumerate(seen):
        scan = [ahead, 0.0, min(ahead, beside), 0.0]
        player.body.sense([0.2 * i, x, y, heading, 0.0, 0.0, 0.0, *scan], ())
        player.tick()
        velocity, _ = player.body.act()
        if velocity:  # none where a round ends
            assert velocity[0] == 0.0 or ahead > 0.5


@given(
    st.lists(st.floats(0.05, 6.0) | st.just(math.inf), min_size=BEAMS, max_size=BEAMS),
    st.integers(0, BEAMS - 1),
)
def test_a_scanner_that_is_mounted_another_way_gives_the_same_features(ranges, turned):
    domain = load_domain("irsim_robots.domain:DOMAIN")
    (scan,) = (sensor for sensor in domain.body.sensors if sensor.name == "scan")
    step = math.tau / BEAMS

    def read(yaw: float, seen: list[float]) -> list[float]:
        message = LaserScan(
            angle_min=-math.pi, angle_increment=step, range_min=0.05, range_max=6.0
        )
        message.ranges = [float(distance) for distance in seen]
        return list(scan.read(message, Mount(yaw=yaw)))

    # The same returns, counted from a scanner that faces elsewhere; 18 beams are 90 degrees.
    for beams in (turned, BEAMS // 4):
        elsewhere = list(np.roll(ranges, -beams))
        expected, found = read(0.0, ranges), read(beams * step, elsewhere)
        assert found[0] == pytest.approx(expected[0], abs=1e-5)


@pytest.mark.long
@pytest.mark.skipif(
    importlib.util.find_spec("irsim") is None,
    reason="ir-sim is not installed: docs/irsim.md shows how, into a folder of its own",
)
@pytest.mark.parametrize("yaw", [0.0, math.pi / 2])
def test_the_simulator_says_where_robots_are_and_what_they_see(yaw):
    from irsim_robots.bridge import simulation
    from irsim_robots.room import HEIGHT, WIDTH, room

    world = simulation(room(1, 2, 0.1, yaw))
    robot = world.robot_list[0]
    before = robot.state[:3, 0].copy()
    world.step([np.array([[0.3], [0.0]]), np.array([[0.0], [0.0]])])
    moved = math.dist(robot.state[:2, 0], before[:2])
    assert moved == pytest.approx(0.03, abs=1e-6)
    scan = robot.get_lidar_scan()
    # The ray that runs straight along x meets a wall or what is before it.
    x, y, heading = robot.state[:3, 0]
    for angle, distance in zip(
        np.linspace(scan["angle_min"], scan["angle_max"], len(scan["ranges"])),
        scan["ranges"],
        strict=True,
    ):
        way = heading + yaw + angle
        end = x + distance * math.cos(way), y + distance * math.sin(way)
        assert -1e-6 <= end[0] <= WIDTH + 1e-6
        assert -1e-6 <= end[1] <= HEIGHT + 1e-6
    assert not robot.collision
