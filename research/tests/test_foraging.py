"""The swarms of foragers that are compared in one process bring home the same over topics."""

import foraging
import foraging_roles
import pytest
from hitab_msgs.msg import Order

from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_bringup.processes.bringing_up import temporary_swarm
from hitab_bringup.swarm_files.swarm_file import read_swarm
from hitab_client.runs.shipped import find_file
from hitab_ros import qos
from hitab_world.inprocess import play

SECONDS = 90.0


def swarm(name: str, **parameters):
    """Return a shipped swarm, in a paused lockstep world."""
    described = read_swarm(find_file(name, "swarms", "swarm"))
    assert described.world is not None
    return described.with_world(
        pace="lockstep",
        paused=True,
        parameters={**described.world.parameters, **parameters},
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "hierarchy"),
    [
        ("foraging_two_levels", lambda names: foraging.hierarchy("two_levels", names)),
        ("foraging_commanders", lambda names: foraging.hierarchy("one_level", names)),
        ("foraging_roles", lambda names: foraging_roles.hierarchy("roles", names, 1)),
    ],
)
def test_squads_bring_the_same_boxes_home_over_topics_and_in_one_process(
    home, tmp_path, name, hierarchy
):
    """Foragers bring some home without commanders: what these order is looked at, too."""
    described = swarm(name, duration=SECONDS)
    orders: list[Order] = []
    with temporary_swarm(described, tmp_path) as running:
        squads = [n for n in running.agents.await_agents() if n.startswith("squad_")]
        for squad in squads:
            running.link.subscribe(Order, f"/{squad}/order", orders.append, qos.LATCHED)
        assert running.link.spin_until(lambda: {o.commander for o in orders} == {*squads}, 30.0)
        (episode,) = running.world.play(1, seed=1)
        assert episode.reproducible
    # One order alone would be the first, which a squad gives before it has decided anything.
    given = {squad: {o.order for o in orders if o.commander == squad} for squad in squads}
    assert sum(len(of_one) > 1 for of_one in given.values()) > len(squads) / 2
    assert set.union(*given.values()) <= {
        "Forage",
        "Join",
        "GiveUp",
        "Haul",
        "Explore",
        "Fetch",
        "",
    }
    figures = ForagingParameters.from_dict(dict(described.world.parameters))
    world = ForagingWorld(figures, 1)
    commanded = hierarchy(world.agents)
    (result,) = play(world, commanded.players, between=commanded.confer)
    assert boxes(result.measures) >= 1.0
    assert {m.name: m.value for m in episode.measures} == result.measures


def boxes(measures) -> float:
    return measures["small"] + measures["large"]


def test_roles_are_dealt_out_anew_in_each_squad_and_mean_nothing_where_there_are_none():
    names = [f"{'carrier' if i % 5 else 'scout'}_{i}" for i in range(20)]
    dealt = [foraging_roles.shuffled(names, seed) for seed in (1, 1, 2)]
    assert dealt[0] == dealt[1] != dealt[2]
    for squad in foraging.in_fives(names):
        assert [dealt[0][name] for name in squad].count("scout") == 1
    kind, _ = foraging.trained("foraging_roles")
    alike = foraging_roles.without_roles(kind)
    for order in alike.orders:
        assert order.for_role("scout") == order.for_role("carrier")
    assert any(o.for_role("scout") != o.for_role("carrier") for o in kind.orders)
