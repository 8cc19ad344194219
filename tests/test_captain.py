"""Keepaway with a captain: a trained commander over three keepers, as it is shipped."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.swarm_files.swarm_file import read_swarm
from hitab_client.runs.shipped import find_file
from hitab_client.showing.commander_view import CommanderView

KEEPERS = {"keeper_1": (-7.0, 6.0), "keeper_2": (-3.0, 7.0), "keeper_3": (-5.0, 3.0)}
SECONDS = 60.0


@pytest.fixture(scope="module")
def team(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSwarm]:
    """The shipped swarm, paused; the command finds it too."""
    swarm = read_swarm(find_file("keepaway_captain", "swarms", "swarm")).with_world(paused=True)
    with temporary_swarm(swarm, tmp_path_factory.mktemp("team")) as running:
        running.folder.write(running.record, register=True)
        yield running


@pytest.fixture
def view(team: RunningSwarm) -> CommanderView:
    found = CommanderView(team.agents)
    found.await_groups(SECONDS, ("captain",))
    return found


def put(team: RunningSwarm, ball: tuple[float, float], takers: tuple[float, float]) -> None:
    """Put the ball and both takers somewhere, the keepers to their places; all see it."""
    places = {**KEEPERS, "ball": ball, "taker_1": takers, "taker_2": (takers[0] + 1, takers[1])}
    still = {"vx": 0.0, "vy": 0.0, "heading": 0.0}
    things = {name: {"x": x, "y": y, **still} for name, (x, y) in places.items()}
    team.world.shown(team.world.place(things))


def ordered(team: RunningSwarm, view: CommanderView, order: str) -> bool:
    def all_obey() -> bool:
        group = view.groups["captain"]
        return group.order == order and all(member.obeys for member in group.subordinates)

    return team.link.spin_until(all_obey, SECONDS)


def test_the_captain_orders_what_it_was_taught_in_situations_that_it_was_not_taught(team, view):
    near, far = (-1.0, 4.0), (7.0, -9.0)
    for ball, takers, order in (
        ((-6.0, 5.0), far, "Freeze"),
        ((-6.0, 5.0), near, "Keepaway"),
        ((9.0, -5.0), near, "Regroup"),
        ((-5.0, 4.5), near, "Keepaway"),
        ((-5.0, 4.5), far, "Freeze"),
        ((9.0, -5.0), far, "Regroup"),
    ):
        put(team, ball, takers)
        assert ordered(team, view, order), f"{order} was expected; see {view.groups['captain']}"
        for name in KEEPERS:
            assert team.link.spin_until(
                lambda n=name, o=order: team.agents.statuses[n].behavior == o, SECONDS
            )


def test_a_person_orders_by_the_command_line_and_sees_who_obeys(team, view, hitab):
    done = hitab("order", "captain", "Freeze")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "captain performs Freeze and orders Freeze: 3 of 3 perform it\n"
    shown = hitab("tree")
    assert shown.stdout.splitlines()[0] == "captain: orders Freeze: 3 of 3 perform it"
    assert [line[4:] for line in shown.stdout.splitlines()[1:4]] == [
        f"{name}: Freeze" for name in KEEPERS
    ]
    assert "captain gives Freeze until another order" in shown.stderr
    back = hitab("order", "captain", "Captain")
    assert "captain performs Captain and orders" in back.stdout
    refused = hitab("order", "captain", "Attack")
    assert refused.returncode == 1
    assert (
        'unknown behavior "Attack" (known: Captain, Freeze, Keepaway, Regroup)' in refused.stderr
    )
    refused = hitab("order", "keeper_1", "Freeze")
    assert "keeper_1 is not a commander (known: captain)" in refused.stderr
    checked = hitab("library", "check", "--agent", "captain")
    assert checked.returncode == 0, checked.stderr
