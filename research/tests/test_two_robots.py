"""Two robots in ir-sim are compared with written rules, over the same rooms."""

import importlib.util
import math

import pytest


def test_the_captain_orders_both_robots_to_patrol_and_to_wander_after_a_round():
    from two_robots_runs import hierarchy

    for which in ("trained", "rules"):
        team = hierarchy(which)
        for player in team.players.values():
            player.begin(1, 0)
        orders = []
        # A robot that is at each place in turn, with nothing near, goes round at once.
        places = (1.5, 1.5), (7.5, 1.5), (7.5, 5.5), (1.5, 5.5)
        for i in range(60):
            for player in team.players.values():
                x, y = places[i // 10 % 4]
                scan = [3.0, 0.0, 3.0, 0.0]
                player.sense([0.2 * i, x, y, 0.0, 0.0, 0.0, 0.0, *scan], ())
            team.confer()
            for player in team.players.values():
                player.tick()
            (order,) = {team.agents[name].behavior for name in team.players}  # of both the same
            assert team.agents["captain"].active_path == [order]
            if orders[-1:] != [order]:
                orders.append(order)
        assert orders[:2] == ["Patrol", "Wander"], which


@pytest.mark.long
@pytest.mark.skipif(
    importlib.util.find_spec("irsim") is None,
    reason="ir-sim is not installed: docs/irsim.md shows how, into a folder of its own",
)
def test_two_trained_robots_move_without_collision_whichever_way_their_scanners_face():
    from two_robots_runs import play

    straight, turned = (
        play("trained", 1, 240.0, yaw, lambda seconds: None) for yaw in (0.0, math.pi / 2)
    )
    for name, outcome in straight.items():
        assert outcome.collided is None
        assert outcome.visits
        assert turned[name].visits == outcome.visits
        assert turned[name].collided is None


def test_a_run_counts_places_and_the_first_collision():
    from two_robots import figures
    from two_robots_runs import Outcome

    good, bad = Outcome(), Outcome()
    for at in ((1.5, 1.5), (1.6, 1.5), (4.0, 3.0), (7.5, 1.5), (4.0, 3.0), (7.5, 1.5), (1.5, 1.2)):
        good.see(at)
    bad.collide(3.0)
    bad.collide(4.0)
    assert good.visits == ["A", "B", "A"]
    assert bad.collided == 3.0
    found = figures([{"robot_1": good, "robot_2": bad}, {"robot_1": good, "robot_2": good}])
    assert found["without_collision"] == 1
    collided = found["collided_robots"]
    assert (collided["mean"], collided["se"]) == (0.5, 0.5)
    assert found["places"]["mean"] == 3.0
    assert found["visits"]["mean"] == 4.5
