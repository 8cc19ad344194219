"""Keepers that servo on the ball decide as the recorded one did, and play whole episodes."""

import gzip
import json
import math
import re
from pathlib import Path
from random import Random

import fidelity
from servo_keepers import ServoKeeper

from keepaway_research.reference.eyes import Eyes
from keepaway_world.game.physics import Physics
from keepaway_world.parameters import variant

BALL = re.compile(r"\(\(b\) (\S+) (\S+) (\S+) (\S+)\)")
PLAYER = re.compile(r"\(\(p \w \d \S+\) (\S+) (\S+) (\S+) (\S+) (\S+) ")
CALL = re.compile(r'\(hear \d+ \S+ our \d "p(\d)"')
COMMAND = re.compile(r"\((dash|turn|kick) (\S+?)(?: (\S+))?\)")
DATA = Path(__file__).parents[2] / "ros2_ws/src/hitab_rcssserver/test/data"
TRANSCRIPT = DATA / "keepaway_transcript.jsonl.gz"


def agree(one, other, tolerance) -> bool:
    """Whether two commands are the same within so many units of power and degrees."""
    if one[0] != other[0]:
        return False
    amount = one[1] - other[1]
    if one[0] == "turn":
        amount = math.degrees(math.remainder(amount, 2.0 * math.pi))
    direction = math.degrees(math.remainder(one[2] - other[2], 2.0 * math.pi))
    return abs(amount) <= tolerance and abs(direction) <= tolerance


def test_the_servo_keeper_does_what_the_recorded_one_did():
    """Client 0 of the transcript; what it hears belongs to the cycle in which it is heard."""
    world = Physics(variant("standard"), Random(0))
    eyes, keeper = Eyes(world, world.keepers[0]), ServoKeeper(1)
    same = cycles = 0
    for state, heard, done in transcript():
        for mover, (x, y, vx, vy, body) in zip(world.movers, state, strict=True):
            world.put(mover, x, -y, -math.radians(body), vx, -vy)
        order, _ = keeper.decide(eyes.view(), heard)
        cycles += 1
        same += order is done if None in (order, done) else agree(order, done, 1.0)
    assert cycles == 629
    assert same / cycles > 0.98


def transcript():
    """Yield what client 0 perceived and did in each cycle of play: (x, y, vx, vy, body) of all."""
    perceived, done = None, None
    with gzip.open(TRANSCRIPT, "rt") as file:
        for line in file:
            record = json.loads(line)
            text = record["msg"]
            if record["client"] != 0:
                continue
            if text.startswith("(fullstate"):
                if perceived is not None:
                    yield *perceived, done
                perceived, done = None, None
                if "pmode play_on" in text:
                    perceived = (
                        [(*map(float, BALL.search(text).groups()), 0.0)]
                        + [tuple(map(float, found)) for found in PLAYER.findall(text)],
                        [],
                    )
            elif perceived is None:
                continue
            elif found := CALL.match(text):
                perceived[1].append(f"pass {found[1]}")
            elif record["dir"] == "send" and (found := COMMAND.match(text)):
                kind, amount, direction = found[1], float(found[2]), float(found[3] or 0.0)
                amount = -math.radians(amount) if kind == "turn" else amount
                done = kind, amount, -math.radians(direction)
        if perceived is not None:
            yield *perceived, done


def test_servo_keepers_play_the_same_episodes_with_the_same_seed_and_pass():
    (case,) = (case for case in fidelity.CASES if case.title == "servo, quarter speed")
    figures = fidelity.measure(case, 3, 5)
    assert figures == fidelity.measure(case, 3, 5)
    assert figures["passes"]["mean"] > 1.0
