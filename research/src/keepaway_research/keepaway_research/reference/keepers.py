"""Reference keepers that play whole episodes in one process, for comparison.

These are UT Austin's keepers, with one of the `policies` for the ball.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from random import Random

from hitab_core import agent_seed
from hitab_world.inprocess import Player
from keepaway_research.reference.ball_handling import BallHandling
from keepaway_research.reference.eyes import Eyes
from keepaway_research.reference.interception import Meeting
from keepaway_research.reference.policies import HOLD, Policy, by_distance, hand, hold, rand
from keepaway_research.reference.positioning import get_open, open_point
from keepaway_research.reference.prediction import Predictor, as_sent
from keepaway_research.reference.reaching import Reach
from keepaway_research.reference.view import View
from keepaway_world import action
from keepaway_world.action import Order
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.world import KeepawayWorld

FORWARD = 1.0  # they play towards +x
HOLD_RATIO = 0.7  # of the kickable margin: distance of a held ball from the body

_KINDS = {"dash": action.DASH, "turn": action.TURN, "kick": action.KICK}


class ReferenceKeeper:
    """Decides for one keeper; remembers the last pass and where it meets the ball."""

    def __init__(self, parameters: KeepawayParameters, policy: Policy, random: Random) -> None:
        self._policy = policy
        self._random = random
        self._predictor = Predictor(parameters)
        self.begin()

    def begin(self) -> None:
        """Forget the last episode."""
        self._meeting = Meeting(self._predictor, FORWARD)
        self._last_choice, self._chosen_at = HOLD, -10

    def decide(self, view: View, cycle: int) -> Order:
        """Return the command of a cycle."""
        me, ball = view.me, view.ball
        apart = complex(ball.x - me.x, ball.y - me.y)
        if abs(apart) < self._predictor.kickable:
            return as_sent(self._with_ball(view, cycle))
        reach = Reach(self._predictor, view)
        fastest = reach.fastest(view.keepers, view.takers)
        if fastest is me:
            return as_sent(self._meeting.order(me, ball, view.takers, cycle))
        from_where = self._predictor.ball_after(ball, reach.cycles_to_ball(fastest))
        takers = [complex(t.x, t.y) for t in view.takers]
        others = [complex(p.x, p.y) for p in view.players if p is not me]
        p = view.parameters
        point = open_point((p.width, p.height), from_where, others, takers)
        return as_sent(get_open(self._predictor, me, point, complex(ball.x, ball.y)))

    def _with_ball(self, view: View, cycle: int) -> Order:
        passing = self._last_choice != HOLD and self._chosen_at == cycle - 1
        choice = self._last_choice if passing else self._policy(view, self._random)
        self._last_choice, self._chosen_at = choice, cycle
        handling = BallHandling(self._predictor, view.me, view.ball, view.takers, FORWARD)
        if choice == HOLD:
            return handling.hold(HOLD_RATIO)
        receiver = by_distance(view.keepers, view.me)[choice]
        return handling.pass_to(complex(receiver.x, receiver.y))


class DirectBody:
    """A body for a player that reads the world directly: it only acts."""

    def __init__(self) -> None:
        self.order: Order | None = None

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Begin a cycle; neither the percept nor what is heard is needed."""
        self.order = None

    def act(self) -> tuple[Sequence[float], str]:
        """Return this cycle's command."""
        if self.order is None:
            return [], ""
        kind, amount, direction = self.order
        return [_KINDS[kind], amount, direction], ""


class ReferencePlayer:
    """Plays a keeper by a reference policy; see `hitab_world.inprocess.Player`."""

    def __init__(self, world: KeepawayWorld, name: str, policy: Policy) -> None:
        self.body = DirectBody()
        self._world = world
        self._name = name
        self._random = Random()
        me = next(k for k in world.physics.keepers if k.name == name)
        self._eyes = Eyes(world.physics, me)
        self._keeper = ReferenceKeeper(world.parameters, policy, self._random)

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode, with the player's generator seeded for it."""
        self._random.seed(agent_seed(seed, episode, self._name))
        self._eyes.begin()
        self._keeper.begin()

    def tick(self) -> None:
        """Decide for this cycle."""
        order = self._keeper.decide(self._eyes.view(), self._world.episode_cycle)
        self._eyes.did(order)
        self.body.order = order


def _players(policy: Policy, world: KeepawayWorld) -> Mapping[str, Player]:
    """Return players for all keepers of a world in this process."""
    return {name: ReferencePlayer(world, name, policy) for name in world.agents}


hand_coded, random, holding = (partial(_players, policy) for policy in (hand, rand, hold))
