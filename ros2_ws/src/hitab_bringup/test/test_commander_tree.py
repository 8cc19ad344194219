"""Commanders in swarm descriptions: whole trees in a few lines, and errors in trees."""

import json
from pathlib import Path

import pytest
from hitab_msgs.msg import Subordinate

from hitab_bringup.libraries.opened_library import open_library
from hitab_bringup.libraries.run_libraries import prepare
from hitab_bringup.processes.swarm_processes import processes
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_cli.verbs.perform.hierarchy_verbs import line_of
from hitab_client.errors import DescriptionError
from hitab_client.showing.commander_view import tree_of

HERE = Path("/somewhere/team.yaml")
HEAD = """\
domain: keepaway
agents:
  scout: {count: 4}
  carrier: {count: 16}
kinds:
  Squad:
    orders:
      Attack: {scout: GoFast, carrier: GoSlow}
      Rest: nothing
  Company: {orders: {War: Attack, Peace: Rest}, features: {Where: {group: x}}}
commanders:
"""
TREE = """\
  corporal: {kind: Squad, commands: {scout: 1, carrier: 4}}
  captain: {kind: Company, commands: corporal, behavior: War}
"""


def parsed(text: str):
    return parse_swarm(HEAD + text, HERE)


def complaint(text: str, head: str = HEAD) -> str:
    with pytest.raises(DescriptionError) as error:
        parse_swarm(head + text, HERE)
    return str(error.value)


def test_a_line_makes_as_many_commanders_as_their_groups_need():
    swarm = parsed(TREE)
    by_name = {commander.name: commander for commander in swarm.commanders}
    assert list(by_name) == ["corporal_1", "corporal_2", "corporal_3", "corporal_4", "captain"]
    assert by_name["corporal_2"].subordinates == {
        "scout_2": "scout",
        **{f"carrier_{i}": "carrier" for i in (5, 6, 7, 8)},
    }
    assert by_name["captain"].subordinates == {f"corporal_{i}": "corporal" for i in (1, 2, 3, 4)}
    superiors = {member.name: member.superior for member in swarm.members}
    assert superiors["carrier_16"] == "corporal_4"
    assert superiors["corporal_4"] == "captain"
    assert superiors["captain"] == ""
    assert len(swarm.agent_names) == 25


def test_the_order_of_the_lines_does_not_matter():
    first, second = TREE.splitlines(keepends=True)
    either_way = [
        {commander.name: commander.subordinates for commander in parsed(text).commanders}
        for text in (TREE, second + first)
    ]
    assert either_way[0] == either_way[1]


def test_positions_are_asked_for_all_the_way_down_where_a_commander_above_needs_them():
    assert [commander.asks_position for commander in parsed(TREE).commanders] == [True] * 5
    # The captain needs the positions: without it, no agent reports a position.
    alone = parsed(TREE.splitlines(keepends=True)[0]).commanders
    assert [commander.asks_position for commander in alone] == [False] * 4


def test_without_a_map_the_behaviors_that_all_subordinates_share_are_the_orders():
    swarm = parse_swarm(
        "domain: keepaway\nagents: {a: {}, b: {}}\nkinds: {Plain: {}}\n"
        "commanders: {chief: {kind: Plain, commands: [a, b]}}\n",
        HERE,
    )
    (chief,) = swarm.commanders
    orders = {order.name: dict(order.behaviors) for order in chief.kind.orders}
    assert orders["GetOpen"] == {"": "GetOpen"}
    assert {"GoFast", "Stop", "Pass"} < set(orders)


def test_commanders_stand_beside_what_they_command_in_as_many_hosts_as_wished():
    swarm = parsed("\n".join([TREE.rstrip(), "hosts: 2\n"]))
    found = {process.name: process.agents for process in processes(swarm, Path("/run"))}
    assert set(found) == {"host_1", "host_2"}
    assert sorted(len(names) for names in found.values()) == [12, 13]
    for commander in swarm.commanders[:4]:
        home = next(name for name, inside in found.items() if commander.name in inside)
        assert set(commander.subordinates) < set(found[home])


def test_a_run_folder_tells_each_host_whom_to_run_and_each_library_its_kind(tmp_path):
    swarm = parsed("\n".join([TREE.rstrip(), "hosts: 1\n"]))
    prepare(swarm, tmp_path)
    roster = json.loads((tmp_path / "rosters" / "host_1.json").read_text())
    captain = next(entry for entry in roster if entry["name"] == "captain")
    assert captain["node"] == "hitab_commander.commander_node:CommanderNode"
    assert captain["parameters"]["behavior"] == "War"
    library = open_library(tmp_path / "libraries" / "Company")
    assert sorted(library.domain.behaviors) == ["Peace", "War"]


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        (
            "  a: {kind: Company, commands: b}\n  b: {kind: Company, commands: a}\n",
            12,
            "commanders in a circle: a -> b -> a; remove one of these from `commands:`",
        ),
        (
            "  a: {kind: Squad, commands: [scout, carrier]}\n"
            "  b: {kind: Squad, commands: [carrier_3]}\n",
            13,
            '"carrier_3" has two commanders, "a" and "b"; remove it from one',
        ),
        ("  a: {kind: Squad, commands: [scuot]}\n", 12, 'Did you mean "scout"?'),
        ("  a: {kind: Sqad, commands: scout}\n", 12, 'there is no kind "Sqad" under `kinds:`'),
        ("  a: {kind: Squad, commands: []}\n", 12, "`commands:` is empty"),
        (
            "  a: {kind: Squad, commands: {scout: 1, carrier: 3}}\n",
            12,
            "these counts give different numbers of commanders (4 of scout, 6 of carrier)",
        ),
        ("  scout: {kind: Squad, commands: carrier}\n", 12, 'a second "scout" (see `scout`)'),
    ],
)
def test_whatever_is_no_tree_is_refused_with_its_line(text, line, expected):
    error = complaint(text)
    assert f"/somewhere/team.yaml:{line}: " in error
    assert expected in error


def test_an_order_must_mean_something_for_every_role_and_be_known_to_all(tmp_path):
    error = complaint("  a: {kind: Squad, commands: [b]}\n  b: {kind: Squad, commands: scout}\n")
    assert 'the order "Attack" has no behavior for role "b"; add it, or `others:`' in error
    (tmp_path / "library").mkdir()
    text = (
        "domain: keepaway\nstart_from: library\nagents: {a: {}}\n"
        "kinds:\n  Squad: {orders: {Run: GoFsat}}\n"
        "commanders:\n  chief: {kind: Squad, commands: a}\n"
    )
    with pytest.raises(DescriptionError) as error:
        parse_swarm(text, tmp_path / "team.yaml")
    assert str(error.value).startswith(f"{tmp_path}/team.yaml:7: the order ")
    assert 'gives role "a" the unknown behavior "GoFsat" (known: ' in str(error.value)


def test_what_was_learned_in_an_earlier_run_can_be_ordered_and_performed_at_once(
    tmp_path, monkeypatch
):
    (tmp_path / "library").mkdir()
    text = (
        "swarm: team\ndomain: keepaway\nstart_from: library\nbehavior: Home\n"
        "agents: {a: {}}\nkinds: {Squad: {orders: {Back: Home}}}\n"
        "commanders:\n  chief: {kind: Squad, commands: a, start_from: library, behavior: Lead}\n"
    )

    def learned_in(run: Path) -> None:
        for agent, behavior in (("a", "Home"), ("Squad", "Lead")):
            (run / "libraries" / agent).mkdir(parents=True)
            (run / "libraries" / agent / f"{behavior}.hfa.yaml").touch()

    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    with pytest.raises(DescriptionError, match='unknown behavior "Home"'):
        parse_swarm(text, tmp_path / "team.yaml")
    learned_in(tmp_path / "run")
    assert parse_swarm(text, tmp_path / "team.yaml", tmp_path / "run").agents[0].behavior == "Home"
    learned_in(tmp_path / "home" / "team_left")
    assert parse_swarm(text, tmp_path / "team.yaml").commanders[0].behavior == "Lead"


# -- the displayed tree -------------------------------------------------------------------------


class Group:
    """The parts of a commander's status that the tree needs."""

    def __init__(self, name, subordinates, behaviors, obeying, silent=None, faults=()):
        self.commander = name
        self.behavior, self.order, self.mode, self.active_path = "X", "X", "performing", []
        quiet = silent or [False] * len(subordinates)
        reports = zip(subordinates, behaviors, obeying, quiet, strict=True)
        self.subordinates = [
            Subordinate(name=n, behavior=b, obeys=o, silent=s, stopped=not b)
            for n, b, o, s in reports
        ]
        self.faults = list(faults)


def test_an_agent_performs_the_order_from_above_only_if_all_between_obey():
    groups = {
        "top": Group("top", ["left", "right"], ["X", "Y"], [True, False]),
        "left": Group("left", ["a", "b"], ["X", "X"], [True, False]),
        "right": Group("right", ["c"], ["X"], [True]),
    }
    (top,) = tree_of(groups)
    assert top.counts == (1, 2)
    assert top.leaves == (1, 3)
    assert [branch.leaves for branch in top.below] == [(1, 2), (1, 1)]
    assert top.data()["agents_performing"] == 1


def test_the_tree_says_how_many_cannot_perform_an_order_and_why():
    obeying, silent = [True, False, False, False], [False, True, True, False]
    groups = {"top": Group("top", list("abcd"), ["X", "X", "", ""], obeying, silent)}
    (top,) = tree_of(groups)
    assert [line_of(branch) for branch in (top, *top.below)] == [
        "top: orders X: 1 of 4 perform it (2 silent, 1 stopped)",
        "a: X",
        "b: X  silent",
        "c: nothing  silent",
        "d: nothing  stopped",
    ]
