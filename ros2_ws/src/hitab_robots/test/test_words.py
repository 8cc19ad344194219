"""Ready words on a robot that drives as commanded, or does not."""

import math
import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_core import Domain, FeatureValueError, HitabError, VocabularyError
from hitab_robots import (
    Battery,
    Drive,
    Odometry,
    Robot,
    Scan,
    Sector,
    battery_low,
    distance_to,
    drive_to,
    facing,
    heading_to,
    motion,
    near,
    nearest_bearing,
    nearest_range,
    nearest_return,
    place,
    reading,
    stuck,
    turn_to,
)

ROBOT = Robot(
    (Odometry(), Scan(sectors=(Sector("ahead", 0.0, 0.5), Sector("around"))), Battery()),
    Drive(max_velocity=(0.5, 0.0, 1.0)),
)
DOMAIN = Domain.of(
    "cart",
    "1",
    ROBOT,
    behaviors=(
        motion("Forward", 0.4),
        motion("Left", turn=1.0),
        motion("Stop"),
        drive_to(),
        turn_to(),
    ),
    features=(
        nearest_range("RangeAhead", "scan.ahead"),
        nearest_bearing("BearingOfNearest", "scan.around"),
        distance_to(),
        heading_to(),
        facing(),
        near(within=0.3),
        stuck(),
        battery_low(),
        reading("Speed", "odom.vx", unit="m/s"),
    ),
    targets=(place("home", 0.0, 0.0), nearest_return("obstacle")),
    link="hitab_robots:RobotLink",
)


def sense(body, **given):
    """Have the body perceive; what is not given has no value."""
    values = {name.replace("__", "."): value for name, value in given.items()}
    body.sense([values.get(name, math.nan) for name in ROBOT.values], ())


def read(body, feature, *targets):
    points = [DOMAIN.targets[target].resolve(body) for target in targets]
    return DOMAIN.features[feature].read(body, *points)


def test_declaring_a_robot_needs_no_ros():
    script = (
        "import sys\nfrom hitab_robots import *\n"
        "from hitab_robots import Robot, Scan, stuck\n"
        "assert 'rclpy' not in sys.modules\n"
    ).replace("from hitab_robots import *\n", "")
    subprocess.run([sys.executable, "-c", script], check=True)


def test_a_behavior_drives_within_the_limits_and_without_one_the_robot_is_left_alone():
    body = DOMAIN.body("robot_1")
    assert list(body.act()[0]) == []
    DOMAIN.behaviors["Forward"].pulse(body)
    assert list(body.act()[0]) == [0.4, 0.0, 0.0]
    body.drive(3.0, -3.0, 3.0)
    assert list(body.act()[0]) == [0.5, 0.0, -1.0]
    DOMAIN.behaviors["Stop"].pulse(body)
    assert list(body.act()[0]) == [0.0, 0.0, 0.0]
    sense(body)
    assert list(body.act()[0]) == []


def test_where_things_are():
    body = DOMAIN.body("robot_1")
    sense(
        body,
        odom__x=1.0,
        odom__y=1.0,
        odom__heading=math.pi / 2,
        scan__around__range=2.0,
        scan__around__bearing=-math.pi / 2,
    )
    assert read(body, "DistanceTo", "home") == pytest.approx(math.sqrt(2))
    assert read(body, "HeadingTo", "home") == pytest.approx(math.radians(135))
    assert DOMAIN.targets["obstacle"].resolve(body) == pytest.approx((3.0, 1.0))
    assert read(body, "DistanceTo", "obstacle") == pytest.approx(2.0)
    assert read(body, "HeadingTo", "obstacle") == pytest.approx(-math.pi / 2)
    assert read(body, "BearingOfNearest") == pytest.approx(-math.pi / 2)
    assert math.isnan(read(body, "RangeAhead"))


def test_a_silent_sensor_leaves_its_words_without_a_value():
    body = DOMAIN.body("robot_1")
    sense(body, time=1.0)
    for name, feature in DOMAIN.features.items():
        assert math.isnan(read(body, name, *["home"] * len(feature.parameters))), name


def test_a_robot_does_not_drive_without_what_it_needs_for_that_and_may_stand_still():
    careful = replace(ROBOT, needed_to_drive=("scan", "odom.x"))
    body = careful("robot_1")
    body.drive(0.0)
    with pytest.raises(FeatureValueError, match="scan has no value, and the robot must not drive"):
        body.drive(0.1)
    sense(body, scan__around__range=2.0)  # nothing is known of what is ahead: it is not blind
    with pytest.raises(FeatureValueError, match=r"odom\.x has no value"):
        body.drive(0.1)
    sense(body, scan__around__range=2.0, odom__x=0.0)
    body.drive(0.1)
    assert list(body.act()[0]) == [0.1, 0.0, 0.0]
    with pytest.raises(VocabularyError, match=r'"sacn" in `needed_to_drive`.*Did you mean "scan"'):
        replace(ROBOT, needed_to_drive=("sacn",))


def drive(body, seconds, velocity, moves=1.0, turns=1.0, *, begin=0.0):
    """Drive for a while, and sense what comes of it; return whether it was stuck, each time."""
    x = heading = 0.0
    found = []
    for step in range(round(seconds * 10) + 1):
        sense(body, time=begin + step / 10, odom__x=x, odom__y=0.0, odom__heading=heading)
        found.append(read(body, "Stuck"))
        body.drive(*velocity)
        x += body.velocity[0] / 10 * moves
        heading = math.remainder(heading + body.velocity[2] / 10 * turns, math.tau)
    return found


def test_who_was_told_to_move_and_did_not_is_stuck():
    for velocity, moves, turns, expected in [
        ((0.4, 0.0), 1.0, 1.0, 0.0),
        ((0.4, 0.0), 0.1, 1.0, 1.0),
        ((0.0, 1.0), 1.0, 1.0, 0.0),
        ((0.0, 1.0), 1.0, 0.0, 1.0),
        ((0.4, 1.0), 0.0, 1.0, 0.0),  # it turns at least
        ((0.0, 0.0), 1.0, 1.0, 0.0),  # commanded to stand still
        ((5.0, 0.0), 0.9, 1.0, 0.0),  # what is beyond its limits is not expected of it
    ]:
        found = drive(DOMAIN.body("robot_1"), 5.0, velocity, moves, turns)
        assert {*found[:20]} == {0.0}  # it takes some time to be sure
        assert {*found[21:]} == {expected}


def test_a_clock_that_is_set_back_does_not_look_like_being_stuck():
    body = DOMAIN.body("robot_1")
    drive(body, 5.0, (0.4, 0.0), begin=100.0)
    assert {*drive(body, 1.9, (0.4, 0.0), 0.0)} == {0.0}


def test_what_the_robot_does_not_have_is_named():
    body = DOMAIN.body("robot_1")
    with pytest.raises(VocabularyError, match=r'unknown value "scan\.ahed\.range" of the robot'):
        body["scan.ahed.range"]
    with pytest.raises(VocabularyError, match="a percept has 2 values"):
        body.sense([1.0, 2.0], ())
    with pytest.raises(VocabularyError, match='a second sensor "odom"'):
        Robot((Odometry(), Odometry()))
    with pytest.raises(VocabularyError, match="looks back 60 s"):
        stuck(seconds=60.0)


def test_a_commander_hears_where_the_robot_is_unless_it_does_not_know():
    robot = Robot((Odometry(), Scan()))
    body = robot("robot_1")
    assert body.position is None
    values = dict.fromkeys(robot.values, math.nan) | {"odom.x": 1.0, "odom.y": 2.0}
    body.sense(list(values.values()), ())
    assert body.position == (1.0, 2.0)
    assert Robot((Scan(),))("robot_1").position is None


def moved(behavior, x, y, heading, seconds=40.0):
    """Return where a robot is after a behavior to the target home: m, m, rad."""
    body = DOMAIN.body("robot_1")
    for step in range(round(seconds * 10)):
        sense(body, time=step / 10, odom__x=x, odom__y=y, odom__heading=heading)
        DOMAIN.behaviors[behavior].pulse(body, (0.0, 0.0))
        ahead, _, turn = body.act()[0]
        heading += turn / 10
        x += ahead / 10 * math.cos(heading)
        y += ahead / 10 * math.sin(heading)
    return x, y, heading


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-math.pi, math.pi))
def test_a_robot_drives_to_a_place_from_anywhere(x, y, heading):
    there = moved("DriveTo", x, y, heading)
    assert math.hypot(*there[:2]) < 0.1
    assert moved("DriveTo", *there, seconds=1.0)[:2] == pytest.approx(there[:2], abs=0.05)


@given(st.floats(0.5, 3.0), st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_a_robot_turns_to_a_place_on_the_spot(distance, angle, heading):
    x, y = distance * math.cos(angle), distance * math.sin(angle)
    there = moved("TurnTo", x, y, heading, seconds=10.0)
    assert there[:2] == (x, y)
    body = DOMAIN.body("robot_1")
    sense(body, odom__x=x, odom__y=y, odom__heading=there[2])
    assert read(body, "Facing", "home") == 1.0
    assert abs(there[2] - heading) < math.pi + 0.1, "the shorter way"


def test_without_odometry_a_robot_cannot_act():
    for known in ({}, {"odom__x": 1.0, "odom__y": 1.0}, {"odom__heading": 0.0}):
        body = DOMAIN.body("robot_1")
        sense(body, time=1.0, **known)
        for behavior in ("DriveTo", "TurnTo"):
            with pytest.raises(HitabError, match=r"now: odom\."):
                DOMAIN.behaviors[behavior].pulse(body, (0.0, 0.0))


def test_no_behavior_drives_at_what_is_no_number():
    body = DOMAIN.body("robot_1")
    sense(body, **{name.replace(".", "__"): 1.0 for name in ROBOT.values if name != "odom.vx"})
    for velocity in ((math.nan,), (0.1, math.inf), (0.1, 0.0, -math.inf)):
        with pytest.raises(HitabError, match=r"now: odom\.vx$"):
            body.drive(*velocity)


def test_what_a_robot_faces():
    for degrees, faces in [(9.0, 1.0), (-9.0, 1.0), (11.0, 0.0), (180.0, 0.0)]:
        body = DOMAIN.body("robot_1")
        sense(body, odom__x=-1.0, odom__y=0.0, odom__heading=math.radians(degrees))
        assert read(body, "Facing", "home") == faces
