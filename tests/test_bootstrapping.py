"""Behavior bootstrapping with real nodes: generations, scores, back, and what may go wrong."""

import shutil

import pytest
from waiting import hanging

from hitab_client import SwarmError
from hitab_client.bootstrapping import Bootstrapping, Configuration, Evaluation, with_condition
from hitab_client.run_folder import libraries_of

ONE, TWO, THREE = "keeper_1", "keeper_2", "keeper_3"
QUICK = Evaluation(episodes=2, seed=5)
NONE = Evaluation(episodes=0)


@pytest.fixture
def team(keepers):
    """The swarm, with a keeper that trains Run, whose first example is a command to go fast."""
    agents = keepers.agents
    shutil.rmtree(keepers.folder.path / "generations", ignore_errors=True)
    for mate in (TWO, THREE):
        agents.perform(mate, "")
    keepers.world.step()  # so that no example is from the same cycle as one before
    agents.begin(ONE, "Run", features=["DistanceTo(ball)", "BallIsKickable"], discard=True)
    agents.command(ONE, "GoFast")
    return keepers


def steps(team, **fields) -> Bootstrapping:
    folder = team.folder.path
    return Bootstrapping(team.agents, fields.pop("world", team.world), folder, **fields)


def places(team) -> dict[str, tuple[float, float]]:
    return {e.name: (e.x, e.y) for e in team.world.state_at(0).entities}


def digests(team) -> set[str]:
    return {status.library_digest for status in team.agents.statuses.values()}


def test_a_generation_is_given_to_the_team_and_scored_and_the_training_goes_on(team):
    before = places(team)
    made = steps(team, who="anna").next(ONE, note="run", evaluation=QUICK)

    assert made.by == "anna" != team.agents.demonstrator
    assert made.score is not None
    assert (made.score.episodes, made.score.seed, made.examples) == (2, 5, 2)
    assert made.score.figures["seconds"].mean > 0.0
    assert made.score.figures["passes"].mean == 0.0
    assert made.team == (TWO, THREE)
    statuses = team.agents.statuses
    assert [statuses[n].mode for n in (ONE, TWO, THREE)] == ["training", *2 * ["performing"]]
    assert statuses[TWO].behavior == statuses[THREE].behavior == "Run"
    assert len(digests(team)) == 1
    training = team.agents.training(ONE)
    assert len(training.examples) == 2
    assert training.features == ("DistanceTo(ball)", "BallIsKickable"), "kept, though unused"
    status = team.world.wait()
    assert (status.mode, status.episodes_left) == ("paused", 0)
    assert places(team) == before, "the evaluation leaves the field as it was arranged"

    team.agents.command(ONE, "Stop")
    child = steps(team).next(ONE, evaluation=QUICK)
    assert (child.number, child.parent) == (made.number + 1, made.number)
    assert child.version == made.version + 1
    again = steps(team).next(ONE, evaluation=QUICK)
    assert again.score == child.score, "the same seed gives the same score"


def test_one_goes_back_to_a_generation_with_the_team(team):
    work = steps(team)
    first = work.next(ONE, evaluation=NONE)
    rules = digests(team)
    team.agents.command(ONE, "Stop")
    last = work.next(ONE, evaluation=NONE)
    assert digests(team) != rules
    team.agents.command(ONE, "GoSlow")
    with pytest.raises(SwarmError, match=r"2 examples changed since it was saved.*--discard"):
        work.back(ONE, "Run", first.number)

    there = work.back(ONE, "Run", first.number, discard=True, evaluation=QUICK)
    assert there.score is not None, "it had no score yet"
    assert there.restored == (last.version + 1,)
    saved = team.agents.behavior(ONE, "Run")
    assert saved.version == last.version + 1
    assert f"generation {first.number} restored" in saved.note
    assert digests(team) == rules
    assert len(team.agents.training(ONE).examples) == 2
    assert {team.agents.statuses[n].behavior for n in (TWO, THREE)} == {"Run"}

    team.agents.command(ONE, "GoMedium")
    assert work.next(ONE, evaluation=NONE).parent == first.number
    with pytest.raises(SwarmError, match=r"has no generation 99 \(known: 1, 2"):
        work.back(ONE, "Run", 99)


def test_ctrl_c_leaves_everything_sound(team):
    def interrupted_at(doing: str):
        def progress(done: int, total: int, what: str) -> None:
            if what.startswith(doing):
                raise KeyboardInterrupt

        return steps(team, progress=progress)

    work = interrupted_at("evaluating")
    with pytest.raises(KeyboardInterrupt):
        work.next(ONE, evaluation=Evaluation(episodes=1000))
    assert "has no score; go back to generation" in work.left
    assert team.agents.statuses[ONE].mode == "training"
    cycle = team.world.step().cycle
    assert team.world.step().cycle == cycle + 1, "the world stands still"
    assert team.world.wait().episodes_left == 0

    work = interrupted_at("waiting")
    waiting = with_condition(Configuration(), "said: keeper_2", ONE)
    with pytest.raises(KeyboardInterrupt):
        work.next(ONE, evaluation=NONE, configuration=waiting)
    assert "is complete and keeper_1 is in training mode" in work.left
    assert team.agents.statuses[ONE].mode == "training"
    assert len(team.agents.training(ONE).examples) == 2


def test_a_mate_that_refuses_or_is_silent_is_named_and_given_it_later(team):
    folder = libraries_of(team.folder.path)[TWO]
    aside = folder.with_name("aside")
    folder.rename(aside)
    folder.write_text("not a folder")
    work = steps(team, patience=1.0)
    with pytest.raises(SwarmError) as wrong, hanging(team, THREE):
        work.next(ONE, evaluation=QUICK)
    folder.unlink()
    aside.rename(folder)
    assert "keeper_2 refuses: " in str(wrong.value)
    assert "keeper_3 does not answer" in str(wrong.value)
    assert 'go back to generation 1 of "Run" with keeper_1' in str(wrong.value)
    assert team.agents.statuses[ONE].mode == "training"

    number = int(str(wrong.value).split("generation ")[1].split()[0])
    made = steps(team).back(ONE, "Run", number, evaluation=QUICK)
    assert made.team == (TWO, THREE)
    assert made.score is not None
    assert not made.missing
