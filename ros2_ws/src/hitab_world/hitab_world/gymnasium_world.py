"""Gymnasium environments and PettingZoo parallel environments as worlds.

This module imports neither library; the user's file does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hitab_world.simulating.simulation import Simulation, Values
from hitab_world.world import Measure


class GymnasiumWorld(Simulation):
    """Base of a world whose steps are those of an environment.

    agent_1 is the first of the environment's ``possible_agents``, agent_2 the second and so on; a
    Gymnasium environment has one agent. An agent that has left the episode keeps its last percept,
    and its actions are ignored. An agent that has not joined the episode perceives zeros.

    Attributes:
        idle: the action of an agent that does nothing. None for the first action of a Discrete
            space, or the numbers of a Box that are nearest to 0.
        env: the environment of this episode; each episode has its own.
        reward: the sum of all agents' rewards in the episode so far.
    """

    measures = (Measure("reward"),)
    idle: Values | None = None
    env: Any = None
    reward: float = 0.0

    def environment(self) -> Any:
        """Return an environment that has ``self.agents`` agents."""
        raise NotImplementedError("define environment(self)")

    def reset(self, seed: int) -> Mapping[str, Values]:
        """Begin an episode; an environment that cannot be a world is a `ValueError`."""
        env = self.env = self.environment()
        if hasattr(env, "agent_iter"):
            raise ValueError("its agents take turns; return its parallel_env instead of its env")
        self._all = env if hasattr(env, "possible_agents") else _Alone(env)
        if (count := len(self._all.possible_agents)) != self.agents:
            raise ValueError(f"set agents = {count}, as the environment has")
        self._theirs = dict(zip(self.names, self._all.possible_agents, strict=True))
        self._percepts: dict[str, Values] = {}
        for name, their in self._theirs.items():
            space = self._all.observation_space(their)
            if not hasattr(space, "low") or len(space.shape) != 1:
                raise ValueError(
                    f"{name} observes {space}, which is no list of numbers; wrap the environment "
                    "with FlattenObservation of Gymnasium, or flatten_v0 of SuperSuit"
                )
            self._percepts[name] = [0.0] * space.shape[0]
            if space.shape[0] != (others := len(self._percepts[self.names[0]])):
                raise ValueError(
                    f"{name} observes {space.shape[0]} numbers and {self.names[0]} {others}; wrap "
                    "the environment with pad_observations_v0 of SuperSuit"
                )
        self._over: set[Any] = set()
        return self._perceived(_parts(self._all.reset(seed=seed % 2**31), "reset", 2)[0])

    def step(self, actions: Mapping[str, Values]) -> Mapping[str, Values]:
        """Advance by one step; an action that is not in its space is a `ValueError`."""
        given = {
            their: self._action(name, self._all.action_space(their), actions[name])
            for name, their in self._theirs.items()
            if their in self._all.agents
        }
        observed, rewards, terminated, truncated, _ = _parts(self._all.step(given), "step", 5)
        self.reward += float(sum(rewards.values()))
        # Some environments keep ended agents in their list of agents.
        self._over |= {their for ends in (terminated, truncated) for their in ends if ends[their]}
        if self._over.issuperset(self._all.agents):
            self.ended = "truncated" if any(truncated.values()) else "terminated"
        return self._perceived(observed)

    def measured(self) -> Mapping[str, float]:
        """Return the reward of the episode so far."""
        return {"reward": self.reward}

    def _perceived(self, observed: Mapping[Any, Values]) -> Mapping[str, Values]:
        for name, their in self._theirs.items():
            self._percepts[name] = observed.get(their, self._percepts[name])
        return self._percepts

    def _action(self, name: str, space: Any, values: Values) -> Any:
        values, action, size = values or self.idle or (), None, 1
        if hasattr(space, "low"):
            action, size = space.low.clip(0, space.high), space.low.size
            if len(values) == size:
                action.flat = values
        elif not (hasattr(space, "n") and hasattr(space, "start")):
            raise ValueError(f"{name} acts in {space}; wrap it so that this is Discrete or a Box")
        elif (number := values[0] if values else space.start) == int(number):
            action = int(number)
        if len(values) not in (0, size) or not space.contains(action):
            raise ValueError(
                f"{name} does {[*values]}, which is not in {space}; have its behaviors return "
                f"{size} of its numbers"
            )
        return action


def _parts(returned: Any, method: str, count: int) -> Sequence[Any]:
    """Return the parts of an environment's answer; `ValueError` for an old interface."""
    if isinstance(returned, tuple | list) and len(returned) == count:
        return returned
    raise ValueError(
        f"its {method}() does not return {count} values, as since Gym 0.26 and PettingZoo 1.22: "
        "reset: observation, info; step: observation, reward, terminated, truncated, info; change "
        "it, or wrap it with Shimmy"
    )


class _Alone:
    """A Gymnasium environment as a parallel one, of one agent."""

    possible_agents = ("agent",)

    def __init__(self, env: Any) -> None:
        self.agents: tuple[str, ...] = self.possible_agents
        self.observation_space = lambda _: env.observation_space
        self.action_space = lambda _: env.action_space
        self._env = env

    def reset(self, seed: int) -> list[dict[str, Any]]:
        return [{"agent": given} for given in _parts(self._env.reset(seed=seed), "reset", 2)]

    def step(self, actions: Mapping[str, Any]) -> list[dict[str, Any]]:
        returned = _parts(self._env.step(actions["agent"]), "step", 5)
        observed, reward, terminated, truncated, info = returned
        if terminated or truncated:
            self.agents = ()
        given = (observed, reward, terminated, truncated and not terminated, info)
        return [{"agent": one} for one in given]
