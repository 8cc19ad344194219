"""What keepers perceive: the layout for any number of players, and how coarsely they see."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_core.texts.errors import HitabError
from keepaway_world.body import NO_PLAYER, KeeperBody
from keepaway_world.game.sight import quantised_direction, quantised_distance, seen_velocity
from keepaway_world.parameters import variant
from keepaway_world.percept import percept_length
from keepaway_world.world import KeepawayWorld


def test_full_sight_gives_what_is_true(quiet, put):
    world = quiet()
    put(
        world,
        keeper_1=(1.0, 2.0, 90.0),
        ball=(1.0, 5.0, 0.3, -0.2),
        keeper_2=(-3.0, 2.0),
        keeper_3=(1.0, -4.0),
        taker_1=(5.0, 2.0),
        taker_2=(1.0, 2.7),
    )
    values, heard = world.percept("keeper_1")
    half = math.pi / 2.0
    expected = [
        1,
        3,
        2,
        20,
        20,
        1,
        2,
        half,
        0,
        0,
        3,
        0,
        3,
        -2,
        4,
        half,
        6,
        math.pi,
        4,
        -half,
        0.7,
        0,
    ]
    assert [abs(v) if abs(v) == pytest.approx(math.pi) else v for v in values] == pytest.approx(
        expected, abs=1e-12
    )
    assert heard == []


@settings(max_examples=30)
@given(st.integers(2, 6), st.integers(0, 5), st.sampled_from(["full", "quantised"]))
def test_every_keeper_of_any_team_can_read_its_percept(keepers, takers, sight):
    world = KeepawayWorld(variant("paper", keepers=keepers, takers=takers, sight=sight), seed=3)
    for number, name in enumerate(world.agents, start=1):
        values, heard = world.percept(name)
        assert len(values) == percept_length(keepers, takers)
        assert all(math.isfinite(value) for value in values)
        body = KeeperBody(name)
        body.sense(values, heard)
        assert body.number == number
        assert len(body.others) == keepers - 1
        assert len(body.takers) == takers
        assert (body.closest_taker() == NO_PLAYER) == (takers == 0)
        truth = {entity.name: entity for entity in world.entities()}
        x, y = body.position
        for place in body.others:
            other = truth[f"keeper_{body.number_at(place)}"]
            dx, dy = body.vector_to(place)
            away = math.hypot(other.x - x, other.y - y)
            assert math.hypot(x + dx - other.x, y + dy - other.y) < 0.06 + 0.07 * away


def test_a_body_refuses_the_percept_of_another_world():
    with pytest.raises(HitabError, match="keeper_1: a percept of 7 values"):
        KeeperBody("keeper_1").sense([0.0] * 7, [])
    with pytest.raises(HitabError, match="link the agent to a keepaway world"):
        KeeperBody("keeper_1").sense([], [])
    with pytest.raises(HitabError, match="link the agent to a keepaway world"):
        KeeperBody("keeper_1").sense([math.nan] * percept_length(3, 2), [])


def test_a_body_notices_that_the_teams_have_changed():
    body = KeeperBody("keeper_1")
    for keepers, takers in ((3, 2), (2, 3), (3, 2)):  # percepts of equal length
        world = KeepawayWorld(variant("paper", keepers=keepers, takers=takers))
        body.sense(*world.percept("keeper_1"))
        assert (len(body.others), len(body.takers)) == (keepers - 1, takers)


# From rcssserver's rule: round(log(d) / 0.1) * 0.1, exponential of that, rounded to 0.1.
def test_distances_are_quantised_as_rcssserver_does():
    for distance, seen in [
        (0.0, 0.0),
        (0.5, 0.5),
        (1.0, 1.0),
        (1.04, 1.0),
        (1.06, 1.1),
        (5.0, 5.0),
        (5.2, 5.0),
        (5.3, 5.5),
        (10.0, 10.0),
        (14.1, 13.5),
        (14.3, 14.9),
    ]:
        assert quantised_distance(distance) == pytest.approx(seen)


@given(st.floats(-math.pi, math.pi))
def test_directions_are_seen_in_whole_degrees(direction):
    seen = math.degrees(quantised_direction(direction))
    assert seen == pytest.approx(round(seen), abs=1e-9)
    assert abs(quantised_direction(direction) - direction) <= math.radians(0.5) + 1e-12


@given(st.floats(0.5, 15.0), st.floats(-3.0, 3.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_velocities_are_seen_in_steps_of_the_change_of_distance_and_direction(far, at, vx, vy):
    dx, dy = far * math.cos(at), far * math.sin(at)
    seen = seen_velocity(dx, dy, vx, vy, far, at)
    radial = (seen[0] * dx + seen[1] * dy) / far
    lateral = (seen[1] * dx - seen[0] * dy) / far
    for value, step in ((radial / far, 0.02), (lateral / far, math.radians(0.1))):
        assert value / step == pytest.approx(round(value / step), abs=1e-6)
    assert math.hypot(seen[0] - vx, seen[1] - vy) <= 0.0101 * far + 0.0009 * far
