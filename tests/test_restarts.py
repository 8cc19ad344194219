"""A process that is killed goes on where it was; a swarm that is brought up again begins anew."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hitab_msgs.msg import Episode
from keepers import begin_anew, trained_keepers
from waiting import hanging, pid_of

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_client import dds_profile
from hitab_core.operations import BeginTraining, Command, DiscardTraining, Perform

SECONDS = 60.0
AGENT = "keeper_1"


def kill(swarm: RunningSwarm, name: str) -> None:
    """Kill a process."""
    os.kill(pid_of(swarm, name), signal.SIGKILL)


def kill_and_await(swarm: RunningSwarm, name: str) -> None:
    """Kill a process and wait until the one after it is heard."""
    if name == "world":
        swarm.world.status = None
        kill(swarm, name)
        assert swarm.link.spin_until(lambda: swarm.world.status is not None, SECONDS)
    else:
        swarm.agents.statuses.pop(name)
        kill(swarm, name)
        assert swarm.link.spin_until(lambda: name in swarm.agents.statuses, SECONDS)


def until(swarm: RunningSwarm, holds: Callable[[], bool]) -> None:
    """Wait for a condition."""
    assert swarm.link.spin_until(holds, SECONDS), (swarm.world.status, swarm.agents.statuses)


@pytest.fixture(scope="module")
def running(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSwarm]:
    """Three keepers in a paused world."""
    with temporary_swarm(trained_keepers(None, "", {}), tmp_path_factory.mktemp("run")) as there:
        yield there


@pytest.fixture
def swarm(running: RunningSwarm) -> RunningSwarm:
    """Return three keepers that do nothing, in a paused world, whoever has been killed before."""
    return begin_anew(running)


def test_a_killed_agent_goes_on_with_what_it_performed(swarm: RunningSwarm) -> None:
    """Without a memory it would come back idle, since nobody has ordered it."""
    swarm.agents.do(AGENT, Perform("GoFast"))
    kill_and_await(swarm, AGENT)
    status = swarm.agents.statuses[AGENT]
    assert (status.mode, status.behavior) == ("performing", "GoFast")

    swarm.agents.do(AGENT, Perform())
    kill_and_await(swarm, AGENT)
    assert swarm.agents.statuses[AGENT].mode == "idle"


def test_a_killed_agent_that_left_its_training_goes_on_with_what_it_did_instead(
    swarm: RunningSwarm,
) -> None:
    swarm.agents.do(AGENT, BeginTraining("Unsaved", features=["Done"]))
    swarm.agents.do(AGENT, Command("Stop"))
    examples = swarm.agents.statuses[AGENT].training.examples
    assert examples > 0
    kill_and_await(swarm, AGENT)
    assert swarm.agents.statuses[AGENT].mode == "training"
    for behavior, mode in (("GoFast", "performing"), ("", "idle")):
        swarm.agents.do(AGENT, Perform(behavior))
        kill_and_await(swarm, AGENT)
        status = swarm.agents.statuses[AGENT]
        assert (status.mode, status.behavior) == (mode, behavior)
        assert (status.training.automaton, status.training.examples) == ("Unsaved", examples)
    swarm.agents.do(AGENT, DiscardTraining())


def test_a_killed_world_goes_on_from_its_latest_state(swarm: RunningSwarm) -> None:
    """Without a memory it would begin at cycle 0 and run as it was started."""
    world = swarm.world
    world.place({"ball": {"x": 3.0, "y": 2.0, "vx": 0.0, "vy": 0.0}})
    world.snapshot("save", "corner")
    world.control("pace", pace="realtime", factor=2.0)
    before = world.step(30)
    ball = {e.name: (e.x, e.y) for e in before.entities}["ball"]
    latest = swarm.folder.path / "state" / "world" / "latest.json"
    until(swarm, lambda: f'"cycle": {before.cycle}' in latest.read_text())

    kill_and_await(swarm, "world")
    status = world.status
    assert status is not None
    assert (status.cycle, status.episode, status.mode) == (before.cycle, before.episode, "paused")
    assert (status.pace, status.factor, status.reproducible) == ("realtime", 2.0, False)
    assert list(world.snapshot("list").names) == ["corner"]
    until(swarm, lambda: not world.status.missing)
    after = world.step(1)
    assert after.cycle == before.cycle + 1
    moved = {e.name: (e.x, e.y) for e in after.entities}["ball"]
    assert moved == pytest.approx(ball, abs=2.0)
    world.snapshot("restore", "corner")
    world.snapshot("delete", "corner")
    kill_and_await(swarm, "world")
    assert list(world.snapshot("list").names) == []


def test_each_episode_is_played_and_told_once_though_the_world_is_killed(
    swarm: RunningSwarm,
) -> None:
    """Without a memory the world would stand still after the restart, and all would be lost."""

    def play(episodes: int) -> tuple[bool, list[Episode]]:
        """Return whether the world was killed before its last episode, and what was played."""
        killed: list[bool] = []

        def progress(seen: int) -> None:
            if seen and not killed:
                pid = pid_of(swarm, "world")
                os.kill(pid, signal.SIGSTOP)
                swarm.link.spin_until(lambda: False, 1.0)  # hears what was published until now
                killed.append(swarm.world.episodes[-1].number + 1 < episodes)
                os.kill(pid, signal.SIGKILL)

        played = swarm.world.play(episodes, seed=5, progress=progress, stall_seconds=SECONDS)
        return killed == [True], played

    swarm.world.control("pace", pace="lockstep")
    for episodes in (20, 400):  # a starved test is too late for few
        was_amid, played = play(episodes)
        if was_amid:
            break
    assert was_amid
    assert [episode.number for episode in played] == list(range(episodes))
    assert {episode.seed for episode in played} == {5}
    assert played[0].reproducible
    assert not played[-1].reproducible


def test_a_swarm_that_is_brought_up_again_begins_anew(home: Path, tmp_path: Path) -> None:
    """What an earlier run in the same folder performed is not taken up; snapshots are kept."""
    for kept in ([], ["five"]):
        with temporary_swarm(trained_keepers(None, "", {}, count=1), tmp_path / "run") as running:
            status = running.world.wait()
            assert status.cycle == 0
            assert list(running.world.snapshot("list").names) == kept
            if kept:
                running.world.snapshot("restore", "five")
                assert running.world.step(1).cycle == 6
            assert running.agents.statuses[AGENT].mode == "idle"
            running.agents.do(AGENT, Perform("GoFast"))
            running.world.step(5)
            running.world.snapshot("save", "five")


def test_damaged_memories_do_not_keep_anybody_from_starting(swarm: RunningSwarm) -> None:
    """They are ignored, and the logs say so."""
    swarm.agents.do(AGENT, Perform("GoFast"))
    swarm.world.step(3)
    state = swarm.folder.path / "state"
    memories = {
        AGENT: state / "restart" / f"{AGENT}.json",
        "world": state / "world" / "latest.json",
    }
    for name, file in memories.items():
        until(swarm, file.exists)
        os.kill(pid_of(swarm, name), signal.SIGSTOP)
        file.write_bytes(b'{"swarm": \xff')
        kill_and_await(swarm, name)
        until(swarm, lambda name=name, file=file: str(file) in swarm.folder.log(name).read_text())
    assert swarm.agents.statuses[AGENT].mode == "idle"
    until(swarm, lambda: swarm.world.status is not None and swarm.world.status.cycle == 0)


@pytest.mark.parametrize("name", [AGENT, "world"])
def test_a_process_that_was_suspended_until_it_was_forgotten_starts_again(
    name: str, home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise those who have forgotten it may not find all of it again, for good."""
    monkeypatch.setattr(dds_profile, "SHORTEST_LEASE_S", 3.0)
    with temporary_swarm(trained_keepers(None, "", {}), tmp_path / "run") as swarm:
        swarm.agents.do(AGENT, Perform("GoFast"))
        node = swarm.link.node
        with hanging(swarm, name) as pid:
            until(swarm, lambda: node.count_publishers(f"/{name}/status") == 0)
        until(swarm, lambda: pid_of(swarm, name) not in (0, pid))
        until(swarm, lambda: node.count_publishers(f"/{name}/status") == 1)
        swarm.world.step(5)
        swarm.agents.do(AGENT, Perform())
        assert "was suspended for" in swarm.folder.log(name).read_text()
