"""The rules in which games on the same field differ: players, beginning and end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from random import Random

from hitab_world import Entity, Look, Measure
from keepaway_world.game.physics import Names, Physics
from keepaway_world.game.players import Takers
from keepaway_world.game.referee import Referee, set_up
from keepaway_world.game.takers import TakerTeam

TAKER = Look("#c94f4f")
BALL_LOOK = Look("#f2c94c", "ball", faces=False, labelled=False, layer=1)


@dataclass(frozen=True)
class Rules:
    """The rules of a game.

    Attributes:
        name: name of the world and its domain.
        looks: looks of the players, by kind.
        measures: measures of an episode.
        referee: creates the referee, which ends episodes.
        takers: creates the opponents, which are part of the world.
        set_up: puts everything in its initial position.
        names: names of the players; see `Physics`.
        marks: further things for viewers, such as a goal.
        center: x coordinate of the field's center on an rcssserver, m.
        stops: reasons for the end of an episode when an rcssserver stops a match, by the beginning
            of the server's play mode, such as "goal_l"; empty if the server plays this game.
    """

    name: str
    looks: Mapping[str, Look]
    measures: Sequence[Measure]
    referee: Callable[[Physics], Referee]
    takers: Callable[[Physics], Takers]
    set_up: Callable[[Physics, Random], None]
    names: Names | None = None
    marks: Sequence[Entity] = ()
    center: float = 0.0
    stops: Sequence[tuple[str, str]] = ()


KEEPAWAY_RULES = Rules(
    "keepaway",
    {"keeper": Look(), "taker": TAKER, "ball": BALL_LOOK},
    (Measure("seconds", "s"), Measure("passes")),
    lambda physics: Referee(physics.parameters),
    TakerTeam,
    set_up,
)
