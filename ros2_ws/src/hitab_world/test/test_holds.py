"""A world holds when an agent says so, goes back, and is slower while an agent is taught."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs import msg

from hitab_world.simulating.control import Control
from hitab_world.simulating.lockstep import RoundAnswers
from hitab_world.simulating.run_state import RunState

HOLD = "a: Wait -> Go"


@pytest.mark.parametrize("pace", ["lockstep", "realtime"])
def test_an_agent_holds_the_world_in_the_cycle_in_which_it_says_so(running, pace):
    running.plays()
    running.control("pace", pace=pace)
    running.more["a"] = {"hold": HOLD}
    running.until(lambda: running.status.held)
    assert (running.status.held, running.status.mode) == (HOLD, "paused")
    cycle = running.world.cycle
    for agent in ("a", "b"):
        shown = running.percepts[agent][-1]
        assert (shown.cycle, shown.look, shown.back, shown.restart) == (cycle, True, True, False)
    assert running.status.cycle == cycle
    running.more.clear()
    running.control("resume")
    running.plays()
    running.until(lambda: not running.status.held)


def test_several_agents_hold_in_the_same_cycle(running):
    running.plays()
    running.more = {"a": {"hold": HOLD}, "b": {"hold": "b: unsure: far"}}
    running.until(lambda: running.status.held)
    assert {*running.status.held.split("; ")} == {HOLD, "b: unsure: far"}


def test_steps_that_are_left_end_where_an_agent_holds_the_world(running):
    running.plays()
    running.control("pause")
    running.more["b"] = {"hold": "b: Go"}
    begun = running.world.cycle
    running.control("step", cycles=50)
    running.until(lambda: running.status.held == "b: Go")
    assert (running.world.cycle, running.node.control.steps_left) == (begun, 0)


def test_an_episode_that_begins_in_the_same_round_is_not_held():
    answers = RoundAnswers(("ann",), lambda name: True)
    world = SimpleNamespace(reset=lambda number, seed: None)
    state = RunState(world, Control("realtime", 1.0, False), answers)
    answers.begin(1)
    answers.take("ann", 1, ([], ""), hold=HOLD)
    state.back = True
    state.begin_episode()
    assert not answers.holds
    assert (state.restart, state.back) == (True, False)


def test_a_late_answer_holds_unless_the_world_has_stood_still_since():
    answers = RoundAnswers(("ann",), lambda name: True)
    answers.look()
    answers.begin(1)
    answers.begin(2)
    answers.take("ann", 1, ([], ""), hold="ann: Go")
    assert answers.holds == {"ann": "ann: Go"}
    answers.begin(3, look=True)
    answers.begin(4)
    answers.take("ann", 2, ([], ""), hold="ann: Go")
    assert not answers.holds


def test_a_late_answer_holds_a_world_in_real_time(running):
    running.plays()
    running.control("pace", pace="realtime")
    running.slow = True
    heard = running.percepts["a"]
    begun = len(heard)
    running.until(lambda: len(heard) > begun + 2)
    late = msg.Action(agent="a", sequence=heard[-2].sequence, hold=HOLD)
    running.answers["a"].publish(late)
    running.until(lambda: running.status.held == HOLD)


def test_the_world_tells_at_once_whether_an_agent_is_taught(running):
    running.plays()
    running.control("pace", pace="realtime")
    assert (running.status.teaching, running.status.taught) == (0.5, False)
    running.more["b"] = {"taught": True}
    running.until(lambda: running.status.taught)
    assert running.node.run_state.speed == 0.5
    running.control("teaching", factor=0.25)
    assert running.node.run_state.speed == 0.25
    running.more.clear()
    running.until(lambda: not running.status.taught)
    assert running.node.run_state.speed == 1.0
    assert "between" in running.control("teaching", factor=1.5).message


class Live(SimpleNamespace):
    """A world that runs by itself."""

    waiting = ""

    def idle(self) -> str:
        return ""


@pytest.mark.parametrize(("world", "speed"), [(SimpleNamespace(), 1.0), (Live(), 2.0)])
def test_a_world_that_runs_by_itself_is_not_slowed_down(world: Any, speed: float):
    answers = RoundAnswers(("ann",), lambda name: True)
    answers.take("ann", 0, ([], ""), taught=True)
    assert RunState(world, Control("realtime", 2.0, False, 0.5), answers).speed == speed


def test_the_world_goes_back_and_its_agents_are_told(running):
    running.plays()
    to = running.world.cycle - 5
    assert running.control("back", to=to).success
    running.until(lambda: running.status.cycle == to)
    assert running.status.mode == "paused"
    shown = running.percepts["a"][-1]
    assert (shown.cycle, shown.look, shown.back) == (to, True, True)
    begun = len(running.percepts["a"])
    running.control("resume")
    running.plays()
    assert not any(percept.back for percept in running.percepts["a"][begun:])


def test_a_world_whose_snapshot_fails_plays_on_and_says_why_it_cannot_go_back(running):
    running.world.broken.add("snapshot")
    running.plays()
    assert not running.status.oldest
    refused = running.control("back", to=running.world.cycle)
    assert not refused.success
    assert "its snapshot fails: KeyError('leaves')" in refused.message
    running.world.broken.clear()
    running.plays()
    running.until(lambda: running.status.oldest)
