"""A world in one file: the class is a world, its functions are a domain, mistakes are named."""

import json
from pathlib import Path

import pytest

from hitab_core import FeatureKind, HitabError, LearningAgent, load_domain
from hitab_world import SimulationWorld, WorldError
from hitab_world.simulating.simulation import SimulationParameters
from hitab_world.testing import Wandering, check_world
from hitab_world.world import Placement

EXAMPLE = Path("examples/corridor.py").read_text()
CORRIDOR = EXAMPLE.replace("    measures = ", "    agents = 2\n    measures = ")


def written(folder: Path, text: str, name: str = "corridor") -> Path:
    path = folder / f"{name}.py"
    path.write_text(text)
    return path


def test_a_simulation_in_a_file_is_a_world(tmp_path):
    path = written(tmp_path, CORRIDOR)
    check_world(
        lambda seed: SimulationWorld(SimulationParameters(str(path)), seed),
        Wandering([[1.0], [-0.5]]),
    )
    assert len(SimulationWorld(SimulationParameters(str(path), 5)).agents) == 5


def test_its_functions_are_a_domain_that_a_notebook_trains(tmp_path):
    domain = load_domain(str(written(tmp_path, CORRIDOR)))
    assert load_domain("corridor").signature == domain.signature, "as a library names it"
    agent = LearningAgent(domain, tmp_path / "library").train("Shuttle")
    assert [*agent.step([0.0], command="Right")] == [1.0]
    agent.step([5.0], command="Left")
    agent.step([0.0], command="Right")
    agent.learn()
    assert [agent.decide([x]) for x in (4.0, 5.0, 1.0)] == ["Right", "Left", "Left"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("(Simulation)", "", "has no class"),
        ("class Corridor", "class Other(Simulation): pass\nclass Corridor", "Other"),
        ("agents = 2", "agents = 0", "whole number from 1"),
        ("percept[0]\n", "percept[0]\n1 / 0\n", "ZeroDivisionError"),
        ("agents = 2", "agents = = 2", "bad.py:12: SyntaxError"),
        ("[x] for", "[float('nan')] for", "the percept of agent_1 is not finite"),
        ("[x] for", "x for", "agent_1 has no list of numbers"),
        ("{name: [x]", "{name + '0': [x]", 'no agent "agent_10"'),
        ("return {name: [x] for name, x in self.x.items()}", "return 3", "returned 3"),
        ("random = Random(seed)", "random = 1 / 0", "bad.py:16: ZeroDivisionError"),
        ("def reset", "def begin", "AttributeError"),
    ],
)
def test_a_mistake_in_the_file_is_named_with_its_place(tmp_path, old, new, told):
    assert old in CORRIDOR
    path = written(tmp_path, CORRIDOR.replace(old, new), "bad")
    with pytest.raises(HitabError) as raised:
        SimulationWorld(SimulationParameters(str(path)))
    assert told in str(raised.value)
    assert str(path) in str(raised.value)


def test_an_ending_that_is_no_text_is_refused(tmp_path):
    text = CORRIDOR.replace("if self.gone > 4.0:", "if True:").replace('"far"', "self.gone > 4.0")
    world = SimulationWorld(SimulationParameters(str(written(tmp_path, text, "bad"))))
    with pytest.raises(WorldError, match=r"bad\.py: Corridor\.step\(\) set ended to False; set"):
        world.step({})


def test_a_step_that_raises_changes_nothing_and_names_its_line(tmp_path):
    text = CORRIDOR.replace(
        "if self.gone > 4.0:", "if 1 / (self.gone < 0.15) and self.gone > 4.0:"
    )
    world = SimulationWorld(SimulationParameters(str(written(tmp_path, text, "half"))))
    world.step({"agent_1": ([1.0], "")})
    before = world.entities(), world.result(), world.snapshot(), world.percept("agent_1")
    with pytest.raises(WorldError, match=r"half\.py:25: ZeroDivisionError: .*; correct the file"):
        world.step({"agent_1": ([1.0], ""), "agent_2": ([1.0], "")})
    assert (world.entities(), world.result(), world.snapshot(), world.percept("agent_1")) == before


def test_an_episode_ends_at_its_longest_and_is_restored_there(tmp_path):
    text = CORRIDOR.replace("    agents = 2\n", "    agents = 2\n    longest = 3\n")
    world = SimulationWorld(SimulationParameters(str(written(tmp_path, text, "short"))))
    assert [world.step({}) for _ in range(3)] == [None, None, "time"]
    kept = world.snapshot()
    world.reset()
    world.restore(kept)
    assert (world.ended, world.episode_cycle) == ("time", 3)


def test_a_class_without_reset_begins_with_a_step_in_which_nothing_is_done(tmp_path):
    reset = CORRIDOR.partition("    def reset")[2].partition("    def step")[0]
    text = CORRIDOR.replace(f"    def reset{reset}", "    x, gone = {'agent_1': 2.0}, 0.0\n\n")
    text = text.replace("agents = 2", "agents = 1")
    world = SimulationWorld(SimulationParameters(str(written(tmp_path, text, "plain"))))
    assert world.percept("agent_1") == ([2.0], [])


def test_a_step_may_change_the_actions_it_is_given(tmp_path):
    text = CORRIDOR.replace("actions.items():", "((n, actions.pop(n)) for n in [*actions]):")
    world = SimulationWorld(SimulationParameters(str(written(tmp_path, text, "pops"))))
    world.step({"agent_1": ([1.0], "")})
    kept, percept = world.snapshot(), world.percept("agent_1")
    world.reset()
    world.restore(kept)
    assert world.percept("agent_1") == percept


def test_a_snapshot_is_refused_once_the_file_has_changed(tmp_path):
    path = written(tmp_path, CORRIDOR, "edited")
    kept = SimulationWorld(SimulationParameters(str(path))).snapshot()
    path.write_text(CORRIDOR.replace("0.1 *", "0.2 *"))
    with pytest.raises(WorldError, match="not as it was when the snapshot was taken"):
        SimulationWorld(SimulationParameters(str(path))).restore(kept)


def test_a_file_with_the_name_of_an_installed_domain_is_refused(tmp_path):
    with pytest.raises(HitabError, match='"keepaway" is installed; rename the file'):
        load_domain(str(written(tmp_path, CORRIDOR, "keepaway")))
    assert "Position" not in load_domain("keepaway").features


PLACED = CORRIDOR.replace(
    "    def draw(self)",
    """    def place(self, things):
        for name, to in things.items():
            self.x[name] = to.get("x", self.x[name])
        return self.percepts()

    def draw(self)""",
)


def test_what_is_placed_is_perceived_at_once_and_a_snapshot_keeps_it(tmp_path):
    path = written(tmp_path, PLACED, "placed")
    check_world(
        lambda seed: SimulationWorld(SimulationParameters(str(path)), seed), Wandering([[1.0]])
    )
    world = SimulationWorld(SimulationParameters(str(path)))
    world.step({"agent_1": ([1.0], "")})
    world.place([Placement("agent_1", x=2.0), Placement("agent_2", y=1.0)])
    assert world.percept("agent_1") == ([2.0], [])
    world.step({"agent_1": ([1.0], "")})
    kept, there = world.snapshot(), world.entities()
    with pytest.raises(WorldError, match="KeyError: 'ball'"):
        world.place([Placement("agent_1", x=9.0), Placement("ball", x=0.0)])
    assert (world.snapshot(), world.entities()) == (kept, there)
    world.reset()
    world.restore(json.loads(json.dumps(kept)))
    assert world.entities() == there
    assert world.percept("agent_1") == ([2.1], [])


def test_a_file_that_places_nothing_says_what_to_define(tmp_path):
    world = SimulationWorld(SimulationParameters(str(written(tmp_path, CORRIDOR))))
    with pytest.raises(WorldError, match=r"agent_1 cannot be moved; define place\(self, things\)"):
        world.place([Placement("agent_1", x=1.0)])


def test_a_word_tells_its_unit_its_kind_and_its_parameters(tmp_path):
    words = '''
from hitab_core import FeatureKind, target


@feature(unit="m")
def DistanceTo(percept, X):
    """how far it is"""
    return abs(X - percept[0])


@feature(kind=FeatureKind.BOOLEAN, required=True)
def Low(percept):
    return percept[0] < 1.0


@behavior
def GoTo(percept, X):
    return [1.0 if percept[0] < X else -1.0]


@behavior(one_shot=True)
def Beep(percept):
    return [0.0]


@target
def door(percept):
    return 3.0
'''
    domain = load_domain(str(written(tmp_path, CORRIDOR + words, "told")))
    distance, low = domain.features["DistanceTo"], domain.features["Low"]
    assert (distance.parameters, distance.unit) == (("X",), "m")
    assert distance.description == "how far it is"
    assert (low.kind, low.required) == (FeatureKind.BOOLEAN, True)
    assert domain.behaviors["Beep"].one_shot
    agent = LearningAgent(domain).train("Reach", ["DistanceTo(door)"])
    assert agent.step([0.5], command="GoTo(door)") == (1.0,)
    assert agent.examples[0].features == (2.5,)
    with pytest.raises(HitabError, match=r"wrong\.py:56: TypeError: .*colour"):
        load_domain(str(written(tmp_path, CORRIDOR + words.replace("unit=", "colour="), "wrong")))


def test_a_file_may_add_words_to_a_domain_that_is_installed(tmp_path):
    crowded = load_domain(str(Path(__file__).parents[4] / "examples/crowded.py"))
    assert (crowded.name, crowded.features["Between"].parameters) == ("crowded", ("X", "Y"))
    assert crowded.features.keys() > load_domain("keepaway").features.keys()
