"""Generations of a behavior on disk, and the training between them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hitab_msgs.msg import Value

from hitab_client.bootstrapping import Bootstrapping, Generation, _keep, read_generations
from hitab_client.errors import LessonError, SwarmError
from hitab_client.learned import Learned
from hitab_client.measures import values_of
from hitab_client.scores import Figure, Score, score_of
from hitab_core import Example, Term


def made(version: int, **others: Any) -> Generation:
    fields: dict[str, Any] = {"at": "2026-01-01T00:00:00Z", "by": "me", "examples": 4}
    return Generation(version=version, **(fields | others))


def test_what_is_kept_is_read_again(tmp_path):
    assert read_generations(tmp_path, "Keepaway") == ()
    scored = Score(episodes=1, seed=7, figures={"a": Figure(mean=1e-5, error=None)})
    all_ = made(1, note='no: "yes"'), made(2, arguments=("ball",)), made(3, score=scored)
    for one in all_:
        _keep(tmp_path, "Keepaway", one)
    assert read_generations(tmp_path, "Keepaway") == all_


def test_a_damaged_list_is_refused_by_line(tmp_path):
    _keep(tmp_path, "Keepaway", made(1))
    path = tmp_path / "Keepaway.yaml"
    path.write_text(path.read_text().replace("version: 1", "version: one"))
    with pytest.raises(SwarmError, match=r"Keepaway.yaml:\d+: `version:` must be a whole number"):
        read_generations(tmp_path, "Keepaway")


def awaited(wait: str) -> str:
    no_swarm: Any = None
    lesson = Bootstrapping(no_swarm, None, None, wait=wait)._waiting("keeper_1")
    assert lesson is not None
    return lesson.steps[1].condition.describe()  # type: ignore[attr-defined]


def test_a_condition_is_given_as_in_a_lesson():
    assert awaited("{said: keeper_2}") == "keeper_2 has said something"
    near = awaited("feature: DistanceTo(ball), below: 2")
    assert near == "DistanceTo(ball) of keeper_1 below 2"
    with pytest.raises(LessonError, match=r"--wait:\d+: not YAML"):
        awaited("{said: ")


@dataclass
class Episode:
    seconds: float
    passes: float = 2.0

    @property
    def measures(self) -> list[Value]:
        return [Value(name="passes", value=self.passes)]


def test_a_score_is_a_mean_with_its_standard_error():
    three: Any = [Episode(1.0), Episode(2.0), Episode(6.0)]
    assert values_of(three) == {"seconds": [1.0, 2.0, 6.0], "passes": [2.0, 2.0, 2.0]}
    score = score_of(three, 3)
    assert str(score) == "3.00 ± 1.53 seconds, 2.00 ± 0.00 passes; 3 episodes, seed 3"

    one: Any = [Episode(1.5, float("nan"))]
    assert str(score_of(one, 1)) == "1.50 seconds; 1 episode, seed 1"
    assert str(Score()) == "no score"


class Swarm:
    """A swarm client that keeps the operation."""

    def do(self, agent: str, operation: Any) -> None:
        self.done = operation


@pytest.mark.parametrize("chosen", [(), ("Stop", "Go")])
def test_the_choice_of_states_is_kept_though_all_of_them_were_commanded(chosen, tmp_path: Path):
    examples = (Example("Start", (), "Go"), Example("Go", (), "Stop"))
    states = (Term("Go"), Term("Stop"))
    training = Learned("Ride", states, (), {}, examples=examples, chosen_states=chosen)
    swarm: Any = Swarm()
    Bootstrapping(swarm, None, tmp_path)._train("ann", training, (), 1)
    assert swarm.done.states == chosen
