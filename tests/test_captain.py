"""Keepaway with a captain: a trained commander over three keepers, as it is shipped."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from hitab_bringup.bringing_up import RunningSwarm, temporary_swarm
from hitab_bringup.opened_library import open_library
from hitab_bringup.swarm_file import read_swarm
from hitab_client.command_view import CommandView
from hitab_client.lessons.lesson_file import read_lesson
from hitab_client.lessons.lesson_player import LessonPlayer
from hitab_client.shipped import find_file, shipped

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
def view(team: RunningSwarm) -> CommandView:
    found = CommandView(team.link)
    found.await_groups(SECONDS, ("captain",))
    return found


def put(team: RunningSwarm, ball: tuple[float, float], takers: tuple[float, float]) -> None:
    """Put the ball and both takers somewhere, the keepers to their places; all see it."""
    places = {**KEEPERS, "ball": ball, "taker_1": takers, "taker_2": (takers[0] + 1, takers[1])}
    still = {"vx": 0.0, "vy": 0.0, "heading": 0.0}
    things = {name: {"x": x, "y": y, **still} for name, (x, y) in places.items()}
    team.world.shown(team.world.place(things))


def ordered(team: RunningSwarm, view: CommandView, order: str) -> bool:
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


def test_a_behavior_goes_to_agents_of_its_domain_and_not_to_their_commander(team, hitab):
    given = hitab("distribute", "keeper_1", "Freeze")
    assert given.returncode == 0, given.stderr
    assert given.stdout == "keeper_2: has it\nkeeper_3: has it\n"
    refused = hitab("distribute", "captain", "Captain")
    assert refused.returncode == 1
    assert "there is no other agent of the domain of captain to send it to" in refused.stderr


def test_the_lessons_teach_again_what_is_shipped_to_the_last_digit(home, tmp_path):
    swarm = read_swarm(find_file("keepaway_captain", "swarms", "swarm"))
    swarm = swarm.with_world(paused=True, pace="lockstep")
    with temporary_swarm(swarm, tmp_path) as team:
        teach(team)


def teach(team: RunningSwarm) -> None:
    for name in ("freeze", "regroup", "captain"):
        lesson = read_lesson(find_file(f"captain/{name}", "lessons", "lesson"))
        LessonPlayer(lesson, team.agents, team.world).play()
    for agent, folder, behavior in (
        ("captain", "captain", "Captain"),
        ("keeper_1", "keepaway_captained", "Freeze"),
        ("keeper_1", "keepaway_captained", "Regroup"),
    ):
        taught = team.agents.behavior(agent, behavior).examples
        there = open_library(shipped("libraries", folder)).load()[behavior].examples
        assert [seen(e.state, e.features, e.next_state) for e in taught] == [
            seen(e.state, e.features, e.next_state) for e in there
        ]


def seen(state: str, values, next_state: str) -> tuple[str, list[float], str]:
    return state, [float(value) for value in values], next_state
