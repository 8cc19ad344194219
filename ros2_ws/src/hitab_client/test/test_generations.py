"""The generations of a behavior as kept on disk."""

from dataclasses import dataclass, field
from pathlib import Path

import pytest

from hitab_client.bootstrapping import Configuration, read_configuration, with_condition
from hitab_client.bootstrapping.evaluating import Figure, Score, score_of
from hitab_client.bootstrapping.generations import (
    Generation,
    Generations,
    behaviors_in,
    held,
    read_generations,
)
from hitab_client.errors import SwarmError
from hitab_core import LibraryError

SHIPPED = Path(__file__).parents[2] / "keepaway_world" / "libraries" / "keepaway"
PLACE = """\
format: 1
place:
  keeper_1: {x: 8, y: -8.5, heading: 180}
  ball: {x: 0, vx: 1}
new_episode: true
wait: {all: [{said: keeper_2}, {active: GoFast}]}
within: 20
"""


def score_with(mean: float, error: float | None, **others) -> Score:
    plain = {"episodes": 1, "seed": 1, "ended": {}, "reproducible": True}
    return Score(figures={"seconds": Figure(mean=mean, error=error)}, **(plain | others))


def made(number: int, mean: float | None = None, **others) -> Generation:
    score = None
    if mean is not None:
        score = score_with(mean, 0.5, episodes=20, ended={"out": 20})
    return Generation(
        number=number,
        parent=number - 1,
        version=number,
        digest="abc",
        at="2026-01-01T00:00:00Z",
        by="me",
        examples=4,
        **({"score": score} | others),
    )


@pytest.fixture
def known(tmp_path) -> Generations:
    return Generations(agent="keeper_1", behavior="Keepaway").but(folder=tmp_path / "keeper_1")


def placed(tmp_path) -> Configuration:
    (tmp_path / "place.yaml").write_text(PLACE)
    return read_configuration(tmp_path / "place.yaml", "keeper_1")


def test_what_is_kept_is_read_again(known, tmp_path):
    first = made(1, 6.25, note='no: "yes"', team=("keeper_2",), restart=placed(tmp_path))
    second = made(2, None, missing={"keeper_3": "refuses: no"}, unscored="a mate", restored=(3, 5))
    single = made(
        3,
        None,
        score=score_with(1e-5, None, seed=7, reproducible=False),
        arguments=("ball",),
    )
    twin = made(4, restart=first.restart)
    kept = known.with_(first).with_(twin).with_(single).with_(second, current=2).keep()
    read = read_generations(known.folder, "keeper_1", "Keepaway")

    assert read == kept
    assert [g.number for g in read.all] == [1, 2, 3, 4]
    assert read.all[0].restart.place["keeper_1"].heading == 180
    assert (
        read.all[0].restart.wait.describe() == "keeper_2 has said something and keeper_1 in GoFast"
    )
    assert behaviors_in(known.folder) == ["Keepaway"]


def test_the_behaviors_of_a_generation_are_kept_word_for_word(known):
    texts = {n: (SHIPPED / f"{n}.hfa.yaml").read_text() for n in ("ApproachBall", "GotoBall")}
    chasing = known.but(behavior="GotoBall").with_(made(1))
    chasing.keep_texts(1, texts)
    assert chasing.texts(1) == texts
    assert list(chasing.texts(1)) == ["ApproachBall", "GotoBall"]

    path = known.folder / "GotoBall" / "0001.bundle.yaml"
    path.write_text(path.read_text().replace("4.5", "5.5"))
    with pytest.raises(LibraryError, match="its digest does not fit"):
        chasing.texts(1)
    path.unlink()
    with pytest.raises(SwarmError, match='bring version 1 of "GotoBall" of keeper_1 back'):
        chasing.texts(1)


def test_the_best_is_among_those_evaluated_alike(known):
    assert known.best() is None
    three = known.with_(made(1, 6.0)).with_(made(2, 9.0)).with_(made(3, 7.0))
    assert three.best().number == 2
    assert three.best(least=True).number == 1
    assert three.best("passes") is None
    other = score_with(1.0, 0.1, episodes=5)
    assert three.with_(made(4, score=other)).best().number == 4
    assert three.with_(made(4)).best().number == 2, "one without a score does not count"


def test_a_list_that_does_not_fit_is_refused(known):
    path = known.folder / "Keepaway.yaml"
    known.with_(made(1), current=1).keep()
    text = path.read_text()
    for changed, message in (
        (text.replace("current: 1", "current: 4"), "each generation needs a number of its own"),
        (text.replace("agent: keeper_1", "agent: keeper_2"), "`agent: keeper_2` is not known"),
    ):
        path.write_text(changed)
        with pytest.raises(SwarmError, match=message):
            read_generations(known.folder, "keeper_1", "Keepaway")


def test_two_steps_at_once_are_refused(tmp_path):
    busy = pytest.raises(SwarmError, match="another generation of this swarm is being made")
    with held(tmp_path), busy, held(tmp_path):
        pass
    with held(tmp_path):
        pass


def test_a_condition_is_added_as_in_a_lesson(tmp_path):
    assert not Configuration()
    waiting = with_condition(Configuration(), "{said: keeper_2}", "keeper_1")
    assert waiting
    assert not waiting.places
    assert waiting.record() == {"wait": {"said": "keeper_2"}}
    bare = with_condition(placed(tmp_path), "feature: DistanceTo(ball), below: 2", "keeper_1")
    assert str(bare) == "keeper_1, ball placed, when DistanceTo(ball) of keeper_1 below 2"
    with pytest.raises(SwarmError, match=r"--wait:\d+: not YAML"):
        with_condition(Configuration(), "{said: ", "keeper_1")
    with pytest.raises(SwarmError, match="there is no world"):
        placed(tmp_path).check(None)


@dataclass
class Episode:
    seconds: float
    ended: str = "out"
    reproducible: bool = True
    measure_names: list[str] = field(default_factory=lambda: ["passes"])
    measures: list[float] = field(default_factory=lambda: [2.0])


def test_a_score_is_a_mean_with_its_standard_error():
    score = score_of([Episode(1.0), Episode(2.0, "taken"), Episode(6.0)], 3)
    assert str(score.figures["seconds"]) == "3.00 ± 1.53"
    assert score.figures["passes"] == Figure(mean=2.0, error=0.0)
    assert score.ended == {"out": 2, "taken": 1}
    assert (score.episodes, score.seed, score.reproducible) == (3, 3, True)

    one = score_of([Episode(1.5, measures=[float("nan")])], 1)
    assert str(one.figures["seconds"]) == "1.50"
    assert "passes" not in one.figures
