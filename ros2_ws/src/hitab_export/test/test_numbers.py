"""A behavior that takes numbers is performed by its exported file as by the engine."""

import math
import random
from types import ModuleType

import pytest

from hitab_core import (
    BasicBehavior,
    BoundedNumber,
    Domain,
    Feature,
    FeatureKind,
    LearningAgent,
    VocabularyError,
)
from hitab_core.plain_body import PlainBody
from hitab_export import exported

NAMES = ("Wind", "Depth", "Sea")


class Boat(PlainBody):
    def steer(self, *numbers):
        self.action = list(numbers)


def reading(index):
    return lambda boat: boat.percept[index]


BOAT = Domain.of(
    "boat",
    "1",
    Boat,
    behaviors=[
        BasicBehavior(
            "Sail",
            Boat.steer,
            numbers=(
                BoundedNumber("direction", -180, 180, "deg", circular=True),
                BoundedNumber("speed", 0, 1),
            ),
        ),
    ],
    features=[
        Feature("Wind", reading(0), FeatureKind.TOROIDAL),
        Feature("Depth", reading(1)),
        Feature("Sea", reading(2), FeatureKind.CATEGORICAL, categories=("calm", "rough", "ice")),
    ],
)


@pytest.fixture
def agent(tmp_path):
    agent = LearningAgent(BOAT, tmp_path).train("Cruise")
    drawn = random.Random(11)
    for _ in range(30):
        agent.step(a_situation(drawn), command=a_command(drawn))
    agent.save()
    return agent


def a_situation(drawn):
    return [drawn.uniform(-4.0, 4.0), drawn.uniform(0.0, 9.0), float(drawn.randrange(3))]


def a_command(drawn):
    return f"Sail(direction={drawn.uniform(-180, 180)}, speed={drawn.random()})"


def test_python_gives_the_numbers_of_the_engine(agent):
    module = ModuleType("exported")
    text = exported(agent.agent.library, "Cruise", "python")
    exec(compile(text, "exported.py", "exec"), module.__dict__)
    robot, drawn = module.__dict__["Cruise"](), random.Random(12)
    agent.perform("Cruise")
    for number in range(300):
        seen = a_situation(drawn)
        if drawn.random() < 0.3:
            seen[drawn.randrange(3)] = math.nan
        expected = agent.step(seen)
        action = robot.tick(dict(zip(NAMES, seen, strict=True)), 0.1 * number, drawn.random)
        assert tuple(action.numbers) == ("direction", "speed")
        assert tuple(action.numbers.values()) == pytest.approx(expected)


@pytest.mark.parametrize("language", ["cpp", "bt.xml"])
def test_other_languages_refuse_what_takes_numbers_by_name(agent, language):
    with pytest.raises(VocabularyError, match='"Sail" in it takes numbers; export it to python'):
        exported(agent.agent.library, "Cruise", language)
