"""A scanner reads the same, however it is mounted and however many rays it has."""

import math
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_robots import Mount, Scan, Sector

QUARTERS = tuple(
    Sector(name, i * math.pi / 2, math.pi / 2)
    for i, name in enumerate(("ahead", "left", "behind", "right"))
)
SCAN = Scan(sectors=QUARTERS)
INF, NAN = math.inf, math.nan


def scan(ranges, first=0.0, step=None, least=0.1, most=8.0):
    """Return a message; by default its rays go round once, from ahead to the left."""
    step = math.tau / max(len(ranges), 1) if step is None else step
    return SimpleNamespace(
        ranges=ranges, angle_min=first, angle_increment=step, range_min=least, range_max=most
    )


def room(bearing):
    """Return how far the walls are: a room of 6 m by 4 m, with the robot 1 m off its middle."""
    dx, dy = math.cos(bearing), math.sin(bearing)
    to_x = ((2.0 if dx > 0 else -4.0) / dx) if abs(dx) > 1e-12 else INF
    to_y = ((2.0 if dy > 0 else -2.0) / dy) if abs(dy) > 1e-12 else INF
    return min(to_x, to_y)


def seen(rays, mount, where=room):
    """Return what a scanner with some rays sees that sits in the robot's middle."""
    step = math.tau / rays
    sign = -1.0 if mount.upside_down else 1.0
    return scan([where(mount.yaw + sign * i * step) for i in range(rays)])


def read(message, sensor=SCAN, mount=None):
    return dict(zip(sensor.fields, sensor.read(message, mount), strict=True))


def same(one, other):
    """Whether two scans of the room read alike, but for the distance between their rays."""
    ranges = all(abs(one[f"{q.name}.range"] - other[f"{q.name}.range"]) < 0.15 for q in QUARTERS)
    # What is nearest behind is in both corners of that sector.
    bearings = [f"{name}.bearing" for name in ("ahead", "left", "right")]
    return ranges and all(abs(one[key] - other[key]) < 0.05 for key in bearings)


yaws = st.floats(-10.0, 10.0)


@settings(max_examples=20)
@given(yaws, st.booleans())
def test_which_way_it_faces_makes_no_difference(yaw, upside_down):
    plain = read(seen(720, Mount()))
    turned = read(seen(720, Mount(yaw=yaw)), mount=Mount(yaw=yaw))
    over = Mount(yaw=yaw, upside_down=upside_down)
    assert same(plain, turned)
    assert same(plain, read(seen(720, over), mount=over))


@settings(max_examples=20)
@given(st.integers(180, 1500), st.integers(180, 1500))
def test_the_number_of_rays_makes_no_difference(some, others):
    assert same(read(seen(some, Mount())), read(seen(others, Mount())))


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), yaws)
def test_things_are_where_they_are_wherever_the_scanner_sits(x, y, yaw):
    at, bearing = 4.0, 0.3
    thing = (at * math.cos(bearing), at * math.sin(bearing))
    dx, dy = thing[0] - x, thing[1] - y
    angle = math.atan2(dy, dx) - yaw
    around = Scan(sectors=(Sector("around"),))
    message = scan([math.hypot(dx, dy)], first=angle, step=0.01)
    found = read(message, around, Mount(x, y, yaw))
    assert found["around.range"] == pytest.approx(at)
    assert found["around.bearing"] == pytest.approx(bearing)


WHOLE = Scan(sectors=(Sector("around"),))


def test_a_ray_means_what_rep_117_says():
    for ranges, expected in [
        ([INF] * 4, 8.0),  # nothing within range
        ([8.0, 9.0, 65.533, INF], 8.0),  # how other drivers say it
        ([NAN] * 4, NAN),  # not measured
        ([0.0] * 4, NAN),
        ([0.05, NAN, -1.0, 0.0], NAN),  # below range_min: no measurement
        ([-INF, INF, INF, INF], 0.1),  # too near to be measured
        ([0.05, 3.0, NAN, INF], 3.0),
        ([0.1, 3.0, 2.0, INF], 0.1),
        ([INF, NAN, NAN, NAN], NAN),  # too little is known to call it clear
        ([INF, INF, NAN, NAN], 8.0),
        ([], NAN),
    ]:
        found = read(scan(ranges), WHOLE)
        assert found["around.range"] == pytest.approx(expected, nan_ok=True)
        near = expected < 8.0
        assert math.isnan(found["around.bearing"]) is not near


def test_rays_without_an_angle_between_them_say_nothing_but_a_single_one_does():
    assert all(map(math.isnan, SCAN.read(scan([1.0, 2.0], step=0.0))))
    assert SCAN.read(scan([2.0], step=0.0))[:2] == [2.0, 0.0]


def test_zero_is_clear_for_scanners_whose_drivers_mean_it():
    sensor = Scan(sectors=(Sector("around"),), zero_is_clear=True)
    assert read(scan([0.0] * 4), sensor)["around.range"] == 8.0
    assert read(scan([0.0, 2.0, 0.0, 0.05]), sensor)["around.range"] == 2.0


def test_the_maximum_can_be_the_same_for_different_scanners():
    sensor = Scan(sectors=(Sector("around"),), max_range=3.5)
    for most in (3.5, 30.0, INF, 0.0, NAN):
        assert read(scan([5.0, INF], most=most), sensor)["around.range"] == 3.5
        assert read(scan([2.0, INF], most=most), sensor)["around.range"] == 2.0


@given(
    st.lists(st.floats(width=32), max_size=50),
    *[st.floats(width=32) for _ in range(4)],
    st.booleans(),
)
def test_whatever_comes_a_reading_is_a_distance_within_range_or_nothing(
    ranges, first, step, least, most, zero_is_clear
):
    sensor = Scan(sectors=QUARTERS, zero_is_clear=zero_is_clear)
    found = read(scan(ranges, first, step, least, most), sensor)
    for sector in QUARTERS:
        distance, bearing = found[f"{sector.name}.range"], found[f"{sector.name}.bearing"]
        assert math.isnan(distance) or 0.0 <= distance < INF
        assert math.isnan(bearing) or abs(bearing) <= math.pi
        assert not (math.isnan(distance) and not math.isnan(bearing))
        if 0.0 < most < INF:
            assert math.isnan(distance) or distance <= most


def test_a_sector_that_the_scanner_does_not_see_has_no_value():
    found = read(scan([2.0] * 91, first=-math.pi / 4, step=math.pi / 180))
    assert found["ahead.range"] == pytest.approx(2.0)
    assert math.isnan(found["behind.range"])
