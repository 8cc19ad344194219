"""The generations of a behavior as kept on disk."""

from dataclasses import dataclass, field

import pytest

from hitab_client.bootstrapping.generations import (
    Figure,
    Generation,
    Generations,
    Score,
    folder_of,
    read_generations,
    score_of,
)
from hitab_client.bootstrapping.steps import _awaited
from hitab_client.errors import SwarmError


def made(version: int, mean: float | None = None, **others) -> Generation:
    score = Score()
    if mean is not None:
        score = Score(episodes=20, seed=1, figures={"seconds": Figure(mean=mean, error=0.5)})
    fields = {"at": "2026-01-01T00:00:00Z", "by": "me", "examples": 4, "score": score}
    return Generation(version=version, **(fields | others))


@pytest.fixture
def kept(tmp_path):
    """Keeps generations, and reads all that there are."""

    def keep(*generations: Generation) -> Generations:
        for generation in generations:
            read_generations(folder_of(tmp_path, "keeper_1"), "Keepaway").keep(generation)
        return read_generations(folder_of(tmp_path, "keeper_1"), "Keepaway")

    return keep


def test_what_is_kept_is_read_again(kept):
    assert kept().all == ()
    first = made(1, 6.25, note='no: "yes"')
    second = made(2, None, unscored="keeper_3 refuses: no", arguments=("ball",))
    single = made(3, score=Score(episodes=1, seed=7, figures={"a": Figure(mean=1e-5, error=None)}))
    assert kept(first, second, single).all == (first, second, single)
    again = second.but(unscored="", score=first.score)
    assert kept(again).all == (first, single, again)


def test_the_best_is_among_those_evaluated_alike(kept):
    assert kept().best() == 0
    three = kept(made(1, 6.0), made(2, 9.0), made(3, 7.0))
    assert three.best() == 2
    assert three.best(least=True) == 1
    assert three.best("passes") == 0
    other = Score(episodes=5, seed=1, figures={"seconds": Figure(mean=1.0, error=0.1)})
    assert kept(made(4)).best() == 2, "one without a score does not count"
    assert kept(made(5, score=other)).best() == 5


def test_a_damaged_list_is_refused_by_line(kept):
    path = kept(made(1)).path
    path.write_text(path.read_text().replace("version: 1", "version: one"))
    with pytest.raises(SwarmError, match=r"Keepaway.yaml:\d+: `version:` must be a whole number"):
        kept()


def test_a_condition_is_given_as_in_a_lesson():
    assert _awaited("{said: keeper_2}", "keeper_1").describe() == "keeper_2 has said something"
    near = _awaited("feature: DistanceTo(ball), below: 2", "keeper_1")
    assert near.describe() == "DistanceTo(ball) of keeper_1 below 2"
    with pytest.raises(SwarmError, match=r"--wait:\d+: not YAML"):
        _awaited("{said: ", "keeper_1")


@dataclass
class Episode:
    seconds: float
    measure_names: list[str] = field(default_factory=lambda: ["passes"])
    measures: list[float] = field(default_factory=lambda: [2.0])


def test_a_score_is_a_mean_with_its_standard_error():
    score = score_of([Episode(1.0), Episode(2.0), Episode(6.0)], 3)
    assert str(score.figures["seconds"]) == "3.00 ± 1.53"
    assert score.figures["passes"] == Figure(mean=2.0, error=0.0)
    assert (score.episodes, score.seed) == (3, 3)

    one = score_of([Episode(1.5, measures=[float("nan")])], 1)
    assert str(one.figures["seconds"]) == "1.50"
    assert "passes" not in one.figures
