"""What a player sees gives where everything is, itself first of all."""

import gzip
import json
import math
import statistics
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hitab_rcssserver.landmarks import LANDMARKS, locate
from hitab_rcssserver.messages import FullState, See, SeenObject, SenseBody, parse_message
from hitab_rcssserver.sighting import Sighting, together

TRANSCRIPT = Path(__file__).parent / "data" / "keepaway_transcript.jsonl.gz"
TEAMS = {"keepers": "l", "takers": "r"}
coordinates = st.floats(-15.0, 15.0)
directions = st.floats(-180.0, 180.0)


def seen_from(x, y, neck, place, name, **changes):
    """Return something as it is seen, exactly, from a pose."""
    away = (place if isinstance(place, complex) else complex(*place)) - complex(x, y)
    direction = math.remainder(math.degrees(math.atan2(away.imag, away.real)) - neck, 360.0)
    return SeenObject(name, abs(away), direction, **changes)


def felt(time=1, speed=0.0, direction=0.0, head=0.0, kicks=0):
    return SenseBody(time, speed, direction, head, kicks)


def player(number=1, side="l"):
    return Sighting((side, number), TEAMS, 0.94, 3.0)


def landmarks(x, y, neck):
    return [seen_from(x, y, neck, place, name) for name, place in LANDMARKS.items()]


@given(
    coordinates, coordinates, directions, st.sets(st.sampled_from(sorted(LANDMARKS)), min_size=2)
)
def test_two_landmarks_are_enough_to_know_where_one_is(x, y, neck, names):
    place, found = locate(seen_from(x, y, neck, LANDMARKS[name], name) for name in names)
    assert place == pytest.approx(complex(x, y), abs=1e-6)
    assert math.remainder(found - neck, 360.0) == pytest.approx(0.0, abs=1e-6)


def test_one_landmark_or_none_is_not_enough():
    assert locate([]) is None
    assert locate([SeenObject(("f", "c"), 3.0, 0.0)]) is None
    sighting = player()
    sighting.see(See(1, (SeenObject(("b",), 3.0, 0.0),)))
    assert sighting.state("play_on") is None


@given(coordinates, coordinates, directions, st.floats(-1, 1), st.floats(-1, 1))
@example(0.0, 5e-324, 0.0, 0.0, 0.0)
def test_a_ball_that_is_seen_to_move_has_its_velocity(x, y, neck, vx, vy):
    ball = 3.0, 4.0
    distance = math.dist((x, y), ball)
    if distance < 0.1:
        return
    ex, ey = (ball[0] - x) / distance, (ball[1] - y) / distance
    closing, turning = vx * ex + vy * ey, math.degrees((vy * ex - vx * ey) / distance)
    seen = seen_from(x, y, neck, ball, ("b",), distance_change=closing, direction_change=turning)
    sighting = player()
    sighting.feel(felt())
    sighting.see(See(1, (*landmarks(x, y, neck), seen)))
    assert sighting.state("play_on").ball == pytest.approx((*ball, vx, vy), abs=1e-5)


def test_a_ball_that_is_not_seen_rolls_on():
    sighting = player()
    sighting.feel(felt())
    ball = seen_from(0, 0, 0, (2.0, 0.0), ("b",), distance_change=1.0, direction_change=0.0)
    sighting.see(See(1, (*landmarks(0, 0, 0), ball)))
    sighting.feel(felt(2))
    assert sighting.state("play_on").ball == pytest.approx((3.0, 0.0, 0.94, 0.0))
    assert sighting.ball_seen_from == math.inf


def test_a_player_without_a_number_is_who_was_there_before():
    sighting = player()
    sighting.feel(felt())
    takers = [
        seen_from(0, 0, 0, place, ("p", "takers", number))
        for number, place in (("1", (5.0, 5.0)), ("2", (-5.0, 5.0)))
    ]
    sighting.see(See(1, (*landmarks(0, 0, 0), *takers)))
    sighting.feel(felt(2))
    unnamed = [
        seen_from(0, 0, 0, (-5.0, 4.5), ("p", "takers")), seen_from(0, 0, 0, (5.5, 5.0), ("p",))
    ]  # fmt: skip
    sighting.see(See(2, (*landmarks(0, 0, 0), *unnamed)))
    places = {p.number: (p.x, p.y) for p in sighting.state("play_on").players if p.side == "r"}
    assert places[1] == pytest.approx((5.5, 5.0))
    assert places[2] == pytest.approx((-5.0, 4.5))


def test_together_everyone_is_where_they_have_themselves_and_the_ball_where_it_is_nearest():
    near, far = player(1), player(2)
    for sighting, x, ball in ((near, 0.0, 1.0), (far, 9.0, 1.4)):
        sighting.feel(felt())
        other = ("p", "keepers", "2" if sighting is near else "1")
        sighting.see(
            See(
                1,
                (
                    *landmarks(x, 0.0, 0.0),
                    seen_from(x, 0.0, 0.0, (ball, 0.0), ("b",)),
                    seen_from(x, 0.0, 0.0, (5.0, 5.0), other),
                ),
            )
        )
    state = together([far, near], "play_on")
    assert state.ball[0] == pytest.approx(1.0)
    assert {p.number: (round(p.x, 6), round(p.y, 6)) for p in state.players} == {
        1: (0.0, 0.0),
        2: (9.0, 0.0),
    }
    assert together([player()], "play_on") is None


def test_a_kick_that_is_felt_is_told():
    sighting = player()
    sighting.see(See(1, (*landmarks(0, 0, 0),)))
    for kicks, kicked in ((3, False), (3, False), (4, True), (4, False)):
        sighting.feel(felt(kicks=kicks))
        assert sighting.state("play_on").players[0].kicked is kicked


def test_in_the_recording_players_know_where_they_are_and_where_the_ball_is():
    sighting, truth = player(), None
    place, body, ball = [], [], []
    with gzip.open(TRANSCRIPT, "rt") as lines:
        for line in map(json.loads, lines):
            if line["client"] != 0 or line["dir"] != "recv":
                continue
            message = parse_message(line["msg"])
            if isinstance(message, SenseBody):
                sighting.feel(message)
            elif isinstance(message, FullState):
                truth = message
            elif isinstance(message, See):
                sighting.see(message)
                state = sighting.state(truth.mode)
                me, real = state.players[0], truth.players[0]
                place.append(math.dist((me.x, me.y), (real.x, real.y)))
                body.append(abs(math.remainder(me.body - real.body, 360.0)))
                if sighting.ball_seen_from < math.inf:
                    away = math.dist(state.ball[:2], truth.ball[:2])
                    ball.append(away / max(1.0, sighting.ball_seen_from))
    assert len(place) > 400
    assert statistics.median(place) < 0.1  # distances to landmarks are rounded to 0.1 m and 1%
    assert max(place) < 0.3
    assert max(body) < 0.5  # directions are rounded to 1 degree
    assert max(ball) < 0.3  # distances are rounded to 10%
