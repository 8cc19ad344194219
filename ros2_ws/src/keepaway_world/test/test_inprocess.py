"""Whole episodes in one process."""

import math

from hitab_core.automaton import START, Automaton
from hitab_core.repertoire import Repertoire
from hitab_core.term import Term
from hitab_core.transition_function import HandWritten
from hitab_world.inprocess import perform, play, play_on
from hitab_world.world import Placement
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld


def automaton(name, states, features, choose):
    """Return an automaton that decides by one function in all its states."""
    function = HandWritten(choose, tuple(range(len(features))))
    return Automaton(
        name,
        tuple(Term.parse(state) for state in states),
        tuple(Term.parse(feature) for feature in features),
        dict.fromkeys((START, *states), function),
    )


CONTROL_BALL = Automaton(
    "ControlBall",
    tuple(Term(state) for state in ("ServoBall", "Stop", "Pass", "Done")),
    (Term.parse("DistanceTo(closest_taker)"), Term("BallIsKickable")),
    {
        **dict.fromkeys(
            (START, "ServoBall", "Stop"),
            HandWritten(
                lambda taker, kickable: (
                    "ServoBall" if not kickable else "Pass" if taker < 5.0 else "Stop"
                ),
                (0, 1),
            ),
        ),
        "Pass": HandWritten(lambda: "Done"),
    },
)

KEEPAWAY = automaton(
    "Keepaway",
    ("GetOpen", "ControlBall"),
    ("ATeammateIsCloserToBall", "IWasYelledAt"),
    lambda closer, yelled: "GetOpen" if closer and not yelled else "ControlBall",
)

REPERTOIRE = Repertoire(DOMAIN, {a.name: a for a in (CONTROL_BALL, KEEPAWAY)})


def test_the_hand_written_approach_takes_a_keeper_to_the_ball(quiet):
    for x, y, heading in ((-8.0, 3.0, 0.0), (5.0, 5.0, 0.5), (2.0, -9.0, 3.0)):
        world = quiet(takers=0, sight="quantised")
        world.place([Placement("keeper_1", x, y, heading), Placement("ball", 0.0, 0.0)])
        players = {"keeper_1": perform(world, REPERTOIRE, "ServoBall")["keeper_1"]}
        play_on(world, players, cycles_max=30)
        keeper = world.entities()[1]
        assert math.hypot(keeper.x, keeper.y) < world.parameters.kickable


def test_hand_written_keepers_hold_the_ball_longer_than_idle_ones():
    world = KeepawayWorld(seed=3)
    idle = play(world, {}, 20, cycles_max=3000)
    playing = play(world, perform(world, REPERTOIRE, "Keepaway"), 20, cycles_max=3000)
    assert sum(r.cycles for r in playing) > 1.5 * sum(r.cycles for r in idle)
    assert sum(r.measures["passes"] for r in playing) >= 20.0
    assert sum(r.measures["passes"] for r in idle) == 0.0
    assert all(r.ended for r in [*idle, *playing])  # none was cut off


def test_episodes_are_the_same_whatever_was_played_before():
    world = KeepawayWorld(seed=3)
    players = perform(world, REPERTOIRE, "Keepaway")
    results = play(world, players, 6)
    assert [r.number for r in results] == [0, 1, 2, 3, 4, 5]
    again = KeepawayWorld(seed=3)
    assert play(again, perform(again, REPERTOIRE, "Keepaway"), 2, first=4) == results[4:]
    assert play(world, players, 1)[0].number == 6
