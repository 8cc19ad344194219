"""Each process gives signs of life, so that others notice within two seconds when it hangs."""

from __future__ import annotations

import math
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hitab_msgs.msg import Alive
from waiting import hanging, pid_of

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_ros import SignsOfLife, qos

SECONDS = 30.0
SWARM = """\
swarm: signs
domain: keepaway
world: {kind: keepaway, pace: realtime, paused: true}
agents:
  keeper_1: {}
  keeper_2: {host: both}
  keeper_3: {host: both}
kinds:
  Pair:
    orders: {Halt: Stop}
    features: {BallDistance: {minimum: DistanceTo(ball)}}
commanders:
  captain: {kind: Pair, commands: [keeper_2, keeper_3], host: both}
  major: {kind: Pair, commands: [keeper_1]}
"""
ALL = {"keeper_1", "keeper_2", "keeper_3", "captain", "major", "world"}


@pytest.fixture(scope="module")
def swarm(home: Path, tmp_path_factory) -> Iterator[RunningSwarm]:
    """Agents and commanders, alone and on a host, and a paused world."""
    folder = tmp_path_factory.mktemp("signs")
    with temporary_swarm(parse_swarm(SWARM, folder / "signs.yaml"), folder / "run") as running:
        yield running


def listening(swarm: RunningSwarm) -> SignsOfLife:
    """Listen until every process was heard."""
    signs = swarm.agents.signs_of_life(has_world=True)
    heard: dict[str, str] = {}

    def hear(sign: Alive) -> None:
        heard[sign.process] = sign.swarm

    swarm.link.subscribe(Alive, "/alive", hear, qos.SIGNS_OF_LIFE)
    assert swarm.link.spin_until(
        lambda: len(heard) == 4 and {"keeper_1", "major", "world"} < heard.keys(),
        SECONDS,
    ), heard
    assert set(heard.values()) == {swarm.record.identity}
    # A host that hangs cannot tell any more whom it runs.
    assert swarm.link.spin_until(lambda: signs.last_signs.keys() == ALL, SECONDS), signs.last_signs
    assert swarm.link.spin_until(lambda: not signs.silent(), SECONDS)
    return signs


@pytest.mark.parametrize(
    ("process", "silent"),
    [
        ("keeper_1", {"keeper_1"}),
        ("both", {"keeper_2", "keeper_3", "captain"}),
    ],
)
def test_a_process_that_hangs_is_noticed_with_all_whom_it_runs(swarm, process, silent):
    signs = listening(swarm)
    with hanging(swarm, process):
        # On a busy machine another one may be late, but not for long.
        assert swarm.link.spin_until(lambda: signs.silent().keys() == silent, SECONDS), (
            signs.silent()
        )
    assert swarm.link.spin_until(lambda: not signs.silent(), SECONDS), "it is heard again"


def test_a_restarted_agent_perceives_a_paused_world(swarm):
    """It would refuse each command until somebody lets the world run or moves something."""
    process, agent = "both", "keeper_3"
    before = swarm.agents.statuses.pop(agent)
    os.kill(pid_of(swarm, process), signal.SIGKILL)
    assert swarm.link.spin_until(lambda: agent in swarm.agents.statuses, 2 * SECONDS), before

    def perceives() -> bool:
        answer = swarm.agents.read_features(agent, ["DistanceTo(ball)"])
        return not math.isnan(answer.readings[-1].value)

    assert swarm.link.spin_until(perceives, SECONDS), "it has perceived nothing"
