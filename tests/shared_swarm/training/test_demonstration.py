"""A demonstrator trains an agent over the public topics and services, while it runs."""

import pytest
from hitab_msgs.msg import Example
from waiting import hanging

from hitab_client.errors import SwarmError
from hitab_core.domain import load_domain
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.operations import (
    BeginTraining,
    Command,
    Distribute,
    RetimeExamples,
    SaveBehavior,
    TakeOver,
    Test,
)

ONE, TWO, THREE = "keeper_1", "keeper_2", "keeper_3"
BALL_AT = {"x": 0.0, "y": 0.0, "vx": 0.0, "vy": 0.0}


def put(swarm, distance: float) -> None:
    """Put keeper_1 so far from the ball, which lies ahead, and let it see that."""
    keeper = {"x": -distance, "y": 0.0, "heading": 0.0, "vx": 0.0, "vy": 0.0}
    takers = {"taker_1": {"x": -9.0, "y": 9.0}, "taker_2": {"x": -8.0, "y": 9.0}}
    swarm.world.shown(swarm.world.place({ONE: keeper, "ball": BALL_AT, **takers}))


def teach_to_stop(swarm) -> None:
    """Teach keeper_1, in training, to run at the ball and to stop 2 s later."""
    put(swarm, 8.0)
    swarm.agents.do(ONE, Command("GoFast"))
    swarm.world.step(20)
    swarm.agents.do(ONE, Command("Stop"))


@pytest.fixture
def begun(keepers):
    """The swarm, with keeper_1 in a new training."""
    keepers.agents.do(ONE, BeginTraining("Near", features=["DistanceTo(ball)"], discard=True))
    return keepers


def test_a_command_that_comes_late_is_recorded_with_what_it_was_meant_for(begun):
    """The robot runs at the ball; a person who wanted it to stop at once is 0.5 s late."""
    agents, world = begun.agents, begun.world
    put(begun, 8.0)
    agents.do(ONE, Command("GoFast"))
    state = world.step(20)
    taught = agents.do(ONE, Command("Stop", seen=state.cycle - 5))
    assert list(taught.examples) == [3, 4]
    late = {e.number: e for e in agents.training(ONE).examples}
    assert late[3].cycle == state.cycle - 5
    assert late[3].ago == pytest.approx(0.5)
    agents.do(ONE, RetimeExamples([3], 1.0))
    later = agents.training(ONE)
    assert {e.cycle for e in later.examples if e.number in (3, 4)} == {state.cycle - 10}
    assert later.done[-1] == "example 3 due 1 s before its command"
    with pytest.raises(SwarmError, match=r"is too long ago: .*; give a number from 0 to"):
        agents.do(ONE, RetimeExamples([3], 20.0))
    with pytest.raises(SwarmError, match="cannot have been due 1 s after it was given; give"):
        agents.do(ONE, RetimeExamples([3], -1.0))


def test_what_was_trained_is_tested_taken_over_saved_and_distributed(begun):
    agents = begun.agents
    put(begun, 8.0)
    agents.do(ONE, Command("GoFast"))
    put(begun, 2.0)
    agents.do(ONE, Command("Stop"))
    agents.do(ONE, Test(restart=True))
    put(begun, 9.0)
    begun.world.step(3)
    assert begun.link.spin_until(lambda: list(agents.statuses[ONE].active_path) == ["GoFast"], 5)
    agents.do(ONE, TakeOver())
    put(begun, 4.0)
    agents.do(ONE, Command("GoSlow"))
    kinds = [e.kind for e in agents.training(ONE).examples]
    assert kinds.count(Example.CORRECTION) == 1

    saved = agents.do(ONE, SaveBehavior(description="stop near the ball"))
    library = BehaviorLibrary(saved.path.rsplit("/", 1)[0], load_domain("keepaway"))
    assert len(library.load()["Near"].examples) == 6
    report = agents.distribute(ONE, Distribute("Near", start=True))
    assert (report.accepted, report.refused, report.silent) == ([TWO, THREE], {}, [])
    for agent in (TWO, THREE):
        assert begun.link.spin_until(lambda a=agent: agents.statuses[a].behavior == "Near", 5)
    digests = {agents.statuses[name].library_digest for name in (ONE, TWO, THREE)}
    assert len(digests) == 1


def test_the_command_line_trains_too(keepers, hitab, tmp_path):
    steps = [
        ("train", ONE, "ByHand", "-f", "DistanceTo(ball)", "--discard"),
        ("demonstrate", ONE, "Stop"),
        ("demonstrate", ONE, "GoFast"),
        ("examples", "list", ONE),
        ("vocabulary", ONE),
        ("undo", ONE),
        ("test", ONE, "--restart"),
        ("save", ONE, "--description", "stands"),
        ("distribute", ONE, "ByHand", "--to", TWO),
    ]
    told = []
    for step in steps:
        done = hitab(*step)
        assert done.returncode == 0, done.stderr
        told.append(done.stdout)
    assert "ByHand has 2 examples (1 default)" in told[1]
    assert "4 examples, 1 overruled by a command" in told[3]
    assert "DirectionTo(X)  circular" in told[4]
    assert "ByHand.hfa.yaml" in told[7]
    assert told[8] == "keeper_2: accepted\n"
    listed = hitab("examples", "list", ONE, "ByHand", "--json", str(tmp_path / "e.json"))
    assert listed.returncode == 0
    assert "2 examples" in listed.stdout
    shown = hitab("library", "show", "ByHand", "-l", str(keepers.folder.path / f"libraries/{ONE}"))
    assert "Stop" in shown.stdout


def test_what_is_not_saved_yet_is_neither_sent_nor_performed(begun, hitab):
    begun.agents.do(ONE, BeginTraining("Fresh", features=["DistanceTo(ball)"], discard=True))
    begun.agents.do(ONE, Command("GoFast"))
    for verb in ("distribute", "perform"):
        refused = hitab(verb, ONE, "Fresh")
        assert refused.returncode == 1
        assert '"Fresh" is being trained and not saved yet' in refused.stderr
        assert f"`hitab save {ONE}`" in " ".join(refused.stderr.split())
    for name, why in (("Start", "is reserved"), ("GoFast", 'is a basic behavior of domain "keep')):
        refused = hitab("save", ONE, "--name", name)
        assert f'error: {ONE}: "{name}" {why}' in refused.stderr


def test_a_step_without_an_agent_says_who_was_missing_and_why(begun, hitab):
    with hanging(begun, TWO):
        done = hitab("world", "step")
    assert done.stdout == "stepped 1 cycle\n"
    assert f"but: {TWO}'s process is suspended" in done.stderr
    assert begun.link.spin_until(lambda: not begun.world.wait().missing, 30)


def x_of(state):
    """Return where the agent is, m."""
    return next(e.x for e in state.entities if e.name == ONE)


def test_an_agent_that_is_unsure_halts_says_why_and_goes_on_when_it_is_sure(begun, hitab):
    agents, world = begun.agents, begun.world
    teach_to_stop(begun)
    cautious = ("--when-unsure", "halt", "--distance", "1.5")
    told = hitab("test", ONE, "--restart", *cautious)
    assert "when it is farther than 1.5 from any example: halt" in told.stdout, told.stderr
    put(begun, 8.0)
    world.step(2)
    assert not agents.statuses[ONE].caution.unsure
    put(begun, 40.0)
    place = x_of(world.step(3))
    assert begun.link.spin_until(lambda: "nearest one" in agents.statuses[ONE].caution.unsure, 10)
    assert x_of(world.step(5)) == pytest.approx(place, abs=0.3)
    assert "unsure: Near" in hitab("status").stdout
    put(begun, 8.0)
    world.step(2)
    assert begun.link.spin_until(lambda: not agents.statuses[ONE].caution.unsure, 10)
    refused = hitab("test", ONE, "--when-unsure", "halt")
    assert "needs to know when an agent is unsure" in refused.stderr
    assert hitab("test", ONE, "--when-unsure", "go_on").returncode == 0
