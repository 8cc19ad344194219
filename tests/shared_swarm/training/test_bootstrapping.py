"""Behavior bootstrapping with real nodes: generations, scores, back, and what may go wrong."""

import shutil
from functools import partial

import pytest
from waiting import hanging

from hitab_client import LessonError, SwarmError
from hitab_client.bootstrapping import (
    Bootstrapping,
    Generation,
    generations_folder,
    read_generations,
)
from hitab_client.runs.run_folder import libraries_of
from hitab_core.operations import BeginTraining, Command, DiscardTraining, Perform

ONE, TWO, THREE = "keeper_1", "keeper_2", "keeper_3"
QUICK = {"episodes": 2, "seed": 5}
NONE = {"episodes": 0}


@pytest.fixture
def team(keepers):
    """The swarm, with a keeper that trains Run, whose first example is a command to go fast."""
    agents = keepers.agents
    shutil.rmtree(keepers.folder.path / "generations", ignore_errors=True)
    for mate in (TWO, THREE):
        agents.do(mate, Perform())
    keepers.world.step()  # so that no example is from the same cycle as one before
    agents.do(
        ONE, BeginTraining("Run", features=["DistanceTo(ball)", "BallIsKickable"], discard=True)
    )
    agents.do(ONE, Command("GoFast"))
    return keepers


def steps(team, **fields) -> Bootstrapping:
    folder = team.folder.path
    return Bootstrapping(team.agents, fields.pop("world", team.world), folder, **fields)


def places(team) -> dict[str, tuple[float, float]]:
    return {e.name: (e.x, e.y) for e in team.world.state_at(0).entities}


def kept(team) -> tuple[Generation, ...]:
    return read_generations(generations_folder(team.folder.path, ONE), "Run")


def digests(team) -> set[str]:
    return {status.library_digest for status in team.agents.statuses.values()}


def test_a_generation_is_given_to_the_team_and_scored_and_the_training_goes_on(team):
    before = places(team)
    made = steps(team, who="anna", **QUICK).next(ONE, note="run")

    assert made.by == "anna" != team.agents.demonstrator
    assert (made.score.episodes, made.score.seed, made.examples) == (2, 5, 2)
    assert made.score.figures["seconds"].mean > 0.0
    assert made.score.figures["passes"].mean == 0.0
    statuses = team.agents.statuses
    assert [statuses[n].mode for n in (ONE, TWO, THREE)] == ["training", *2 * ["performing"]]
    assert statuses[TWO].behavior == statuses[THREE].behavior == "Run"
    assert len(digests(team)) == 1
    training = team.agents.training(ONE)
    assert len(training.examples) == 2
    assert training.feature_labels == ("DistanceTo(ball)", "BallIsKickable"), "kept, though unused"
    status = team.world.wait()
    assert (status.mode, status.episodes_left) == ("paused", 0)
    assert places(team) == before, "the evaluation leaves the field as it was arranged"

    team.agents.do(ONE, Command("Stop"))
    child = steps(team, **QUICK).next(ONE)
    assert child.version == made.version + 1
    again = steps(team, **QUICK).next(ONE)
    assert again.score == child.score, "the same seed gives the same score"


def test_the_training_of_a_teammate_waits_while_it_performs_the_generation(team):
    team.agents.do(TWO, BeginTraining("Sit", features=["DistanceTo(ball)"]))
    steps(team, **NONE).next(ONE)
    status = team.agents.statuses[TWO]
    assert (status.mode, status.behavior, status.training.automaton) == (
        "performing",
        "Run",
        "Sit",
    )
    team.agents.do(TWO, DiscardTraining())


def test_one_goes_back_to_a_generation_with_the_team(team):
    first = steps(team, world=None).next(ONE)
    assert first.score.episodes == 0, "there is no world to play in"
    rules = digests(team)
    team.agents.do(ONE, Command("Stop"))
    last = steps(team, **NONE).next(ONE)
    assert digests(team) != rules
    team.agents.do(ONE, Command("GoSlow"))
    with pytest.raises(SwarmError, match=r"1 change to its training .*--discard"):
        steps(team).back(ONE, "Run", first.version)
    with pytest.raises(LessonError, match="--wait"):
        steps(team, wait="sad").back(ONE, "Run", first.version, discard=True)
    assert len(team.agents.training(ONE).examples) == 6, "nothing has changed"

    there = steps(team, **QUICK).back(ONE, "Run", first.version, discard=True)
    assert there.score.episodes == 2
    assert (there.version, there.note) == (last.version + 1, f"version {first.version} again")
    assert team.agents.behavior(ONE, "Run").version == there.version
    assert digests(team) == rules
    assert len(team.agents.training(ONE).examples) == 2
    assert {team.agents.statuses[n].behavior for n in (TWO, THREE)} == {"Run"}

    with pytest.raises(SwarmError, match=r'has no version 99 of "Run" \(known: 1, 2'):
        steps(team).back(ONE, "Run", 99)


def test_ctrl_c_leaves_everything_sound(team):
    said: list[str] = []

    def interrupted_at(doing: str, **fields):
        def progress(done: int, total: int, what: str) -> None:
            if what.startswith(doing):
                raise KeyboardInterrupt

        return steps(team, progress=progress, say=said.append, **fields)

    with pytest.raises(KeyboardInterrupt):
        interrupted_at("evaluating", episodes=1000).next(ONE)
    assert said[-1].endswith(": no score")
    assert team.agents.statuses[ONE].mode == "training"
    cycle = team.world.step().cycle
    assert team.world.step().cycle == cycle + 1, "the world stands still"
    assert team.world.wait().episodes_left == 0
    assert [g.score.episodes for g in kept(team)] == [0]

    with pytest.raises(KeyboardInterrupt):
        interrupted_at("until", wait="said: keeper_2", **NONE).next(ONE)
    assert said[-1] == "waiting until said: keeper_2 ..."
    assert team.agents.statuses[ONE].mode == "training"
    assert len(team.agents.training(ONE).examples) == 2
    assert len(kept(team)) == 2


def test_a_mate_that_refuses_or_is_silent_is_named_and_given_it_later(team, monkeypatch):
    folder = libraries_of(team.folder.path)[TWO]
    aside = folder.with_name("aside")
    folder.rename(aside)
    folder.write_text("not a folder")
    distribute = partial(team.agents.distribute, seconds=1.0)
    monkeypatch.setattr(team.agents, "distribute", distribute)
    with pytest.raises(SwarmError) as wrong, hanging(team, THREE):
        steps(team, **QUICK).next(ONE)
    folder.unlink()
    aside.rename(folder)
    assert "keeper_2 refuses: " in str(wrong.value)
    assert "keeper_3 does not answer" in str(wrong.value)
    assert "make a generation of what keeper_1 trains" in str(wrong.value)
    assert team.agents.statuses[ONE].mode == "training"
    assert [g.score.episodes for g in kept(team)] == [0]

    made = steps(team, **QUICK).next(ONE)
    assert made.score.episodes == 2
    assert {team.agents.statuses[n].behavior for n in (TWO, THREE)} == {"Run"}
