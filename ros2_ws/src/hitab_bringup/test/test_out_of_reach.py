"""Which line of a swarm file says what a member does out of reach."""

from pathlib import Path
from typing import Any

import pytest

from hitab_bringup.swarm_files.out_of_reach import with_reach
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_bringup.swarm_files.swarm_lines import ReachLine
from hitab_client import DescriptionError

HERE = Path("/somewhere/team.yaml")
SQUADS = """\
domain: keepaway
agents:
  ant: {count: 4 %s}
  lone: {}
kinds: {Squad: {orders: {Go: Stop}}, Army: {orders: {Go: Go}}}
commanders:
  squad: {kind: Squad, commands: {ant: 2} %s}
  chief: {kind: Army, commands: squad %s}
  major: {kind: Army, commands: [chief] %s}
"""


def read(ant: str = "", squad: str = "", chief: str = "", major: str = "", **swarm: Any) -> Any:
    lines = "".join(f"{key}: {value}\n" for key, value in swarm.items())
    more = (f", {text}" if text else "" for text in (ant, squad, chief, major))
    return parse_swarm(lines + SQUADS % tuple(more), HERE)


def halting(swarm: SwarmDescription) -> dict[str, tuple[str, ...]]:
    """Return who must be in reach of those that halt, besides their own commanders."""
    return {
        member.name: member.parameters.get("superiors", ())
        for member in swarm.members
        if member.parameters.get("when_out_of_reach") == "halt"
    }


HALT, GO_ON = "when_out_of_reach: halt", "when_out_of_reach: go_on"


def test_a_file_that_says_nothing_sets_nothing():
    assert all(not member.parameters for member in read().members)


def test_the_line_of_the_swarm_holds_for_all_and_each_waits_for_all_above():
    swarm = read(when_out_of_reach="halt", out_of_reach_after=3)
    assert halting(swarm) == {
        **{f"ant_{i}": ("chief", "major") for i in (1, 2, 3, 4)},
        **{f"squad_{i}": ("major",) for i in (1, 2)},
        **dict.fromkeys(("chief", "major", "lone"), ()),
    }
    assert {member.parameters["out_of_reach_after"] for member in swarm.members} == {3.0}


def test_the_line_of_a_commander_holds_for_its_group_and_for_all_below():
    assert halting(read(squad=HALT)) == {
        **{f"ant_{i}": ("chief",) for i in (1, 2, 3, 4)},
        **{f"squad_{i}": () for i in (1, 2)},
    }
    assert halting(read(chief=HALT)).keys() == {
        *(f"ant_{i}" for i in (1, 2, 3, 4)),
        *("squad_1", "squad_2", "chief"),
    }


def test_the_own_line_of_a_member_counts_more_than_that_of_its_commanders():
    swarm = read(ant=GO_ON, chief=f"{HALT}, out_of_reach_after: 7")
    assert halting(swarm).keys() == {"squad_1", "squad_2", "chief"}
    by_name = {member.name: member.parameters for member in swarm.members}
    assert by_name["ant_1"] == {"when_out_of_reach": "go_on", "out_of_reach_after": 7.0}
    assert halting(read(squad=GO_ON, chief=HALT)).keys() == {"chief"}


def test_who_halts_does_not_wait_for_those_without_whom_its_commander_goes_on():
    swarm = read(ant=HALT, squad=GO_ON, when_out_of_reach="halt")
    assert halting(swarm)["ant_1"] == ()


def test_the_line_of_a_machine_counts_less_than_that_of_a_commander_and_more_than_the_swarms():
    members = [m for m in read().agents if m.name in ("ant_1", "ant_3", "lone")]
    alone = ReachLine()
    lines = {"ant_1": alone, "ant_3": ReachLine(when_out_of_reach="go_on"), "lone": alone}
    members = [member.__class__(member.name, member.domain, process="host") for member in members]
    swarm = ReachLine(when_out_of_reach="go_on", out_of_reach_after=2.0)
    found, _ = with_reach(members, [], lines, swarm, {"host": ReachLine(when_out_of_reach="halt")})
    assert [member.parameters["when_out_of_reach"] for member in found] == [
        "halt",
        "go_on",
        "halt",
    ]
    assert {member.parameters["out_of_reach_after"] for member in found} == {2.0}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            {"when_out_of_reach": "stop"},
            '`when_out_of_reach:` is the text "stop", which is not known',
        ),
        ({"out_of_reach_after": 0}, "`out_of_reach_after:` must be more than 0, not 0"),
        (
            {"parameters": "{when_out_of_reach: halt}"},
            "`when_out_of_reach:` has a line of its own; move it out of the parameters",
        ),
        ({"parameters": "{superiors: [a]}"}, "`superiors:` is set by the swarm itself; leave it"),
    ],
)
def test_what_a_line_cannot_say_is_refused_with_its_place(line, expected):
    with pytest.raises(DescriptionError) as error:
        read(**line)
    assert f"/somewhere/team.yaml:1: {expected}" in str(error.value)
