"""Environments of Gymnasium and PettingZoo are worlds in one file, as any other."""

import json
from pathlib import Path
from zlib import crc32

import pytest

from hitab_world import SimulationWorld, WorldError
from hitab_world.simulating.simulation import SimulationParameters
from hitab_world.testing import Wandering, check_world

TEAM = Path(__file__).parents[1] / "examples/mpe2_team.py"
HEAD = """
import gymnasium
from gymnasium import spaces
from hitab_world import Entity, GymnasiumWorld
from mpe2 import simple_spread_v3, simple_tag_v3


class Game(GymnasiumWorld):
    def draw(self):
        return [Entity(name, "agent", 0.0, 0.0) for name in self.names]

"""
CART = "    def environment(self):\n        return gymnasium.make('{}')\n"
SPREAD = "    agents = 3\n\n    def environment(self):\n        return simple_spread_v3.{}\n"


def world_of(folder: Path, body: str, seed: int = 1, agents: int = 0) -> SimulationWorld:
    path = folder / f"game_{crc32(body.encode())}.py"
    path.write_text(HEAD + body)
    return SimulationWorld(SimulationParameters(str(path), agents), seed)


def played(world: SimulationWorld, *actions: list[float]) -> list[object]:
    """Return what is perceived when all agents do some actions over and over, and the result."""
    seen: list[object] = []
    while not world.ended:
        action = actions[world.episode_cycle % len(actions)]
        world.step(dict.fromkeys(world.agents, (action, "")))
        seen.append([world.percept(name) for name in world.agents])
    return [*seen, world.result()]


@pytest.mark.parametrize(
    ("body", "samples"),
    [
        (CART.format("CartPole-v1"), [[0], [1]]),
        (CART.format("MountainCarContinuous-v0"), [[-1.0], [0.5]]),
        (SPREAD.format("parallel_env()"), [[0], [1], [4]]),
        (SPREAD.format("parallel_env(continuous_actions=True)"), [[0.0, 1.0, 0.0, 0.5, 0.0]]),
    ],
)
def test_an_environment_is_a_world(tmp_path, body, samples):
    check_world(lambda seed: world_of(tmp_path, body, seed), Wandering(samples), 20)


def test_the_same_seed_gives_the_same_episode_and_another_one_another(tmp_path):
    body = CART.format("CartPole-v1")
    first, again, other = (played(world_of(tmp_path, body, s), [0], [1]) for s in (5, 5, 6))
    assert first == again != other


def test_rewards_of_all_agents_add_up_and_the_end_is_named(tmp_path):
    cart = world_of(tmp_path, CART.format("CartPole-v1"))
    result = played(cart, [1])[-1]
    assert result.ended == "terminated"
    assert result.measures == {"reward": result.cycles}, "one for each step that the pole stands"
    team = world_of(tmp_path, SPREAD.format("parallel_env(max_cycles=7)"))
    result = played(team, [2])[-1]
    assert (result.ended, result.cycles) == ("truncated", 7)
    assert result.measures["reward"] < 0.0


LEAVING = """    agents = 2

    def environment(self):
        return Leaving()


class Leaving:
    possible_agents = ["near", "far"]

    def observation_space(self, agent):
        return spaces.Box(-9.0, 9.0, (1,))

    def action_space(self, agent):
        return spaces.Discrete(2)

    def reset(self, seed):
        self.agents, self.at = ["near", "far"], 0
        return {"near": [1.0], "far": [2.0]}, {}

    def step(self, actions):
        assert list(actions) == self.agents, "only they act"
        self.at += 1
        over = {agent: self.at == {"near": 2, "far": 4}[agent] for agent in self.agents}
        acted, self.agents = self.agents, [agent for agent in self.agents if not over[agent]]
        never = dict.fromkeys(acted, False)
        return {a: [10.0 * self.at] for a in acted}, dict.fromkeys(acted, 1.0), over, never, {}
"""


def test_an_agent_that_has_left_perceives_its_last_and_the_others_go_on(tmp_path):
    *seen, result = played(world_of(tmp_path, LEAVING), [1])
    values = [[percept for percept, _ in all_of_them] for all_of_them in seen]
    assert values == [[[10.0], [10.0]], [[20.0], [20.0]], [[20.0], [30.0]], [[20.0], [40.0]]]
    assert (result.ended, result.measures) == ("terminated", {"reward": 6.0})


def test_an_episode_ends_with_all_agents_though_the_environment_keeps_them(tmp_path):
    kept = LEAVING.replace("self.agents = self.agents, [agent", "_ = self.agents, [agent")
    assert kept != LEAVING
    *_, result = played(world_of(tmp_path, kept), [1])
    assert (result.ended, result.cycles, result.measures) == ("terminated", 4, {"reward": 8.0})


OLD = """    def environment(self):
        return Old()


class Old:
    observation_space = spaces.Box(-9.0, 9.0, (2,))
    action_space = spaces.Discrete(2)

    def reset(self, seed):
        return [0.0, 0.0], {}

    def step(self, action):
        return [0.0, 0.0], 1.0, False, {}
"""


def test_an_environment_with_the_old_interface_is_refused_by_that_name(tmp_path):
    with pytest.raises(WorldError, match=r"its step\(\) does not return 5 values, as since Gym"):
        played(world_of(tmp_path, OLD), [1])
    very_old = OLD.replace("[0.0, 0.0], {}\n", "spaces.Box(-9.0, 9.0, (2,)).sample()\n")
    with pytest.raises(WorldError, match=r"its reset\(\) does not return 2 values"):
        world_of(tmp_path, very_old)


def test_an_agent_that_does_nothing_does_what_is_idle(tmp_path):
    body = CART.format("CartPole-v1")
    nothing = played(world_of(tmp_path, body), [])
    assert nothing == played(world_of(tmp_path, body), [0])
    idle = played(world_of(tmp_path, f"    idle = (1,)\n\n{body}"), [])
    assert idle == played(world_of(tmp_path, body), [1]) != nothing


@pytest.mark.parametrize(
    ("body", "told"),
    [
        (SPREAD.format("env()"), "return its parallel_env instead of its env"),
        (SPREAD.format("parallel_env(N=2)"), "set agents = 2, as the environment has"),
        (CART.format("Blackjack-v1"), "agent_1 observes Tuple.*FlattenObservation"),
        (
            "    agents = 4\n\n    def environment(self):\n"
            "        return simple_tag_v3.parallel_env()\n",
            "agent_4 observes 14 numbers and agent_1 16; wrap .* pad_observations_v0",
        ),
        ("    pass\n", r"define environment\(self\)"),
    ],
)
def test_an_environment_that_is_no_world_is_refused_with_the_way_out(tmp_path, body, told):
    with pytest.raises(WorldError, match=told) as raised:
        world_of(tmp_path, body)
    assert "game_" in str(raised.value)


@pytest.mark.parametrize(
    ("name", "action", "told"),
    [
        ("CartPole-v1", [2], r"agent_1 does \[2.0\], which is not in Discrete\(2\)"),
        ("CartPole-v1", [0.5], "return 1 of its numbers"),
        ("CartPole-v1", [0, 1], "return 1 of its numbers"),
        ("MountainCarContinuous-v0", [3.0], r"not in Box\(-1.0, 1.0, \(1,\), float32\)"),
        ("MountainCarContinuous-v0", [0.0, 0.0], "return 1 of its numbers"),
    ],
)
def test_an_action_that_is_not_in_its_space_is_refused_and_changes_nothing(
    tmp_path, name, action, told
):
    world = world_of(tmp_path, CART.format(name))
    before = world.percept("agent_1"), world.result()
    with pytest.raises(WorldError, match=told):
        world.step({"agent_1": (action, "")})
    assert (world.percept("agent_1"), world.result()) == before


def test_a_team_of_an_environment_is_trained_by_command_and_evaluated(hitab, apart):
    path = apart / "mpe2_team.py"
    path.write_text(TEAM.read_text())

    def run(*command: str) -> str:
        done = hitab(*command)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "mpe2_team is up: 3 agents and a world" in run("up", str(path), "--paused")
    run("train", "agent_1", "Spread", "-f", "Lead")
    run("demonstrate", "agent_1", "GoToNearest")
    run("world", "step", "5")
    run("demonstrate", "agent_1", "GoToNext")
    run("save", "agent_1")
    run("down")
    evaluated = ("evaluate", str(path), "-b", "GoToNearest", "-n", "3", "--json", "-")
    figures = json.loads(run(*evaluated))
    assert figures["ended"]["evaluated"] == {"truncated": 3}
    assert json.loads(run(*evaluated))["measures"] == figures["measures"]
