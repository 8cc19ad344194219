"""What deserves a look is found, ranked, and told once for all whom it concerns."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import pytest
from hitab_msgs.msg import (
    AgentStatus,
    CommanderStatus,
    MachineProcess,
    MachineStatus,
    OrderStatus,
    Subordinate,
)

from hitab_client.attention import Attention, Concern, Item, Kind, Seen, others_alike, ranked
from hitab_client.attention.stillness import Doing, Stillness
from hitab_core import Fix
from hitab_ros.timing import PROMPT_S

ANTS = [f"ant_{i}" for i in range(1, 101)]
SQUADS = {f"squad_{i + 1}": ANTS[5 * i : 5 * i + 5] for i in range(20)}
SQUAD_OF = {ant: squad for squad, ants in SQUADS.items() for ant in ants}


def ant(name: str, **fields: Any) -> AgentStatus:
    given = {"mode": "performing", "behavior": "Forage", "active_path": ["Search", "Forward"]}
    order = OrderStatus(commander=SQUAD_OF[name], behavior="Forage")
    common = {"domain": "ants", "armed": True, "library_digest": "aa", "order": order}
    return AgentStatus(agent=name, **common | given | fields)


def squad(name: str, disobeying: Iterable[str] = (), **fields: Any) -> CommanderStatus:
    members = [Subordinate(name=one, behavior="Forage", obeys=True) for one in SQUADS[name]]
    for member in members:
        if member.name in disobeying:
            member.obeys, member.behavior = False, "Rest"
    return CommanderStatus(
        commander=name, order="Forage", superior="chief", subordinates=members, **fields
    )


def healthy(**changed: AgentStatus) -> Seen:
    return Seen({name: ant(name) for name in ANTS} | changed, {s: squad(s) for s in SQUADS}, {})


def items_of(seen: Seen) -> list[Item]:
    """Return what deserves a look if it lasts."""
    attention = Attention(lambda name: "host_1" if name in ANTS[:50] else "host_2")
    assert attention.look(seen, 10.0) == []
    return attention.look(seen, 10.0 + PROMPT_S)


def test_of_a_healthy_swarm_nothing_deserves_a_look():
    assert items_of(healthy()) == []


def test_members_that_do_not_perform_the_order_are_one_item_with_the_way_out():
    seen = healthy()
    groups = {**seen.groups, "squad_2": squad("squad_2", ["ant_6", "ant_8"])}
    (item,) = items_of(replace(seen, groups=groups))
    assert (item.kind, item.names, item.group) == (Kind.DISOBEYS, ("ant_6", "ant_8"), "squad_2")
    assert str(item) == ("2 ants of squad_2: performs Rest instead of what squad_2 orders, Forage")
    assert Fix.PERFORM(agent="ant_8", behavior="Forage") in item.remedies


def test_a_member_that_a_person_trains_or_that_is_silent_or_stopped_does_not_disobey():
    seen = healthy(ant_6=ant("ant_6", mode="training"))
    group = squad("squad_2", ["ant_6", "ant_7", "ant_8"])
    group.subordinates[1].silent = group.subordinates[2].stopped = True
    assert items_of(replace(seen, groups={**seen.groups, "squad_2": group})) == []


def test_an_order_that_cannot_be_obeyed_tells_why():
    order = OrderStatus(commander="squad_2", behavior="Haul", waits=True)
    seen = healthy(
        ant_6=ant("ant_6", order=order, last_error="it has no Haul", faults=["no Haul"])
    )
    groups = {**seen.groups, "squad_2": squad("squad_2", ["ant_6"])}
    (item,) = items_of(replace(seen, groups=groups))
    assert (item.kind, item.why) == (Kind.DISOBEYS, "it has no Haul")


def test_what_is_over_within_a_moment_deserves_no_look_and_what_lasts_is_dated():
    seen = healthy()
    groups = {**seen.groups, "squad_2": squad("squad_2", ["ant_6"])}
    attention = Attention()
    wrong = replace(seen, groups=groups)
    assert attention.look(wrong, 0.0) == attention.look(seen, 1.0) == []
    assert attention.look(wrong, 2.0) == []
    (item,) = attention.look(wrong, 2.0 + PROMPT_S)
    assert item.since == 2.0


def test_a_silent_host_is_one_item_and_nothing_else_is_said_of_its_agents():
    faulty = {name: ant(name, library_digest="bb", faults=["cold"]) for name in ANTS[:50]}
    seen = replace(healthy(**faulty), silent=dict.fromkeys(ANTS[:50], 3.0))
    (item,) = items_of(seen)
    assert (item.kind, item.names, item.agents) == (Kind.SILENT, ("host_1",), 50)
    assert Fix.LOGS(node="host_1") in item.remedies
    (late,) = items_of(replace(healthy(), missing=frozenset(ANTS[:50])))
    assert late.what == "does not answer the world"


def test_a_silent_machine_and_the_faults_of_others_are_told():
    def machine(name: str, *faults: str) -> MachineStatus:
        processes = [MachineProcess(name="host_1", agents=ANTS[:50])]
        return MachineStatus(machine=name, processes=processes, faults=faults)

    known = {"lab_1": machine("lab_1", "its clock is 3 s off"), "lab_2": machine("lab_2", "old")}
    silent, faulty = items_of(replace(healthy(), machines=known, silent_machines={"lab_2": 4.0}))
    assert (silent.kind, silent.names, silent.agents) == (Kind.SILENT, ("lab_2",), 50)
    assert (faulty.kind, faulty.what) == (Kind.FAULT, "its clock is 3 s off")


def test_only_a_robot_without_a_cause_left_waits_to_be_armed():
    waits = "waits to be armed: the emergency stop; that is over"
    seen = healthy(
        ant_1=ant("ant_1", armed=False, stopped=waits, faults=[waits]),
        ant_2=ant("ant_2", armed=False, stopped="stopped: its agent is silent"),
    )
    (item,) = items_of(seen)
    assert (item.kind, item.names, item.remedies) == (
        Kind.UNARMED,
        ("ant_1",),
        (Fix.ARM(robot="ant_1"),),
    )


def test_decisions_far_from_all_examples_are_told_with_the_distance():
    far = ant("ant_3")
    far.caution.decided_at = 12.5
    (item,) = items_of(healthy(ant_3=far))
    assert item.kind is Kind.UNSURE
    assert "12 spreads" in item.why


def test_a_library_that_differs_from_most_can_be_replaced_by_a_mates():
    basic = ant("ant_9", behavior="Release", active_path=[])  # which comes with the domain
    (item,) = items_of(healthy(ant_7=ant("ant_7", library_digest="bb"), ant_9=basic))
    assert item.kind is Kind.LIBRARY
    assert item.remedies == (Fix.GIVE(agent="ant_1", behavior="Forage", receiver="ant_7"),)


def test_where_agents_have_libraries_of_their_own_none_differs():
    own = {name: ant(name, library_digest=name) for name in ANTS[:30]}
    assert items_of(healthy(**own)) == []


def test_an_agent_is_told_once_with_all_that_is_wrong():
    far = ant("ant_3", library_digest="bb")
    far.caution.decided_at = 12.5
    (item,) = items_of(healthy(ant_3=far))
    assert item.kind is Kind.UNSURE
    assert item.why.endswith("; has other behaviors than most")
    assert Fix.GIVE(agent="ant_1", behavior="Forage", receiver="ant_3") in item.remedies


def test_the_more_urgent_comes_first_unless_the_other_concerns_more_than_ten_times_as_many():
    def kinds(stuck: int) -> list[Kind]:
        found = [Concern(Kind.DISOBEYS, "x", "disobeys")]
        found += [Concern(Kind.STUCK, name, "stuck") for name in ANTS[:stuck]]
        return [item.kind for item in ranked(found, {})]

    assert kinds(1) == kinds(9) == [Kind.DISOBEYS, Kind.STUCK]
    assert kinds(11) == [Kind.STUCK, Kind.DISOBEYS]


def test_what_most_groups_of_a_superior_show_is_one_item_of_the_superior():
    superiors = SQUAD_OF | dict.fromkeys(SQUADS, "chief")
    in_all = [Concern(Kind.UNSURE, ants[0], "far") for ants in SQUADS.values()]
    (item,) = ranked(in_all, superiors)
    assert (item.group, len(item.names)) == ("chief", 20)
    assert [item.group for item in ranked(in_all[:3], superiors)] == [
        "squad_1",
        "squad_2",
        "squad_3",
    ]


def test_what_one_was_taught_can_be_given_to_the_others_in_its_situation():
    found = [
        Concern(Kind.STUCK, name, "stuck in Search", teaches="Forage")
        for name in ("ant_1", "ant_2", "ant_12")
    ]
    items = ranked([*found, Concern(Kind.STUCK, "ant_50", "stuck in Carry")], SQUAD_OF)
    first = next(item for item in items if "ant_1" in item.names)
    assert Fix.GIVE(agent="ant_1", behavior="Forage", receiver="ant_2") in first.remedies
    assert others_alike(items, first, "ant_1") == ["ant_2", "ant_12"]


# -- who gets nowhere ---------------------------------------------------------------------------


def watched(
    seconds: int, place: Any, path: Any = lambda name, t: ("Search", "Forward")
) -> set[str]:
    """Return who is stuck after a while, with places and paths by name and time."""
    stillness, stuck = Stillness(), set[str]()
    for t in range(seconds):
        doings = {name: Doing("ants", "Forage", path(name, t)) for name in ANTS}
        stillness.take(float(t), doings, {name: place(name, t) for name in ANTS})
        stuck |= stillness.stuck().keys()
    return stuck


def test_who_stays_while_the_mates_move_is_stuck_whatever_the_speed():
    stays = {"ant_5", "ant_17"}
    for speed in (0.001, 1.0, 1000.0):

        def place(name: str, t: int, speed: float = speed) -> tuple[float, float]:
            trembles = 50.0 + (0.1 if name == "ant_5" else 0.3) * (t % 2)
            return (speed * min(t, trembles), 0.0) if name in stays else (speed * t, 0.0)

        assert watched(100, place) == stays


def test_who_turns_in_a_corner_is_stuck_too():
    def path(name: str, t: int) -> tuple[str, ...]:
        return ("Search", ("Left", "Right")[t % 2] if name == "ant_5" else "Forward")

    assert watched(100, lambda name, t: (0.0 if name == "ant_5" else float(t), 0.0), path) == {
        "ant_5"
    }


@pytest.mark.parametrize("period", [120, 600])
def test_who_waits_no_longer_than_mates_do_is_not_stuck(period: int):
    """A quarter, or one in twenty, waits for half a minute, one after the other."""

    def place(name: str, t: int) -> tuple[float, float]:
        rounds, phase = divmod(t + 6 * int(name[4:]), period)
        return (float(rounds * period + max(phase, 30)), 0.0)

    assert watched(400, place) == set()


def test_in_a_swarm_that_stands_nobody_is_stuck():
    assert watched(100, lambda name, t: (0.0, 0.0)) == set()


def test_who_changes_its_outer_state_is_not_stuck():
    def path(name: str, t: int) -> tuple[str, ...]:
        return (("Search", "Rest")[t // 15 % 2] if name == "ant_5" else "Search", "Forward")

    assert watched(100, lambda name, t: (0.0 if name == "ant_5" else float(t), 0.0), path) == set()


def test_a_new_episode_begins_anew():
    stillness = Stillness()
    doings = {name: Doing("ants", "Forage", ("Search",)) for name in ANTS}
    for t in [*range(70), *range(50)]:
        places = {name: (0.0 if name == "ant_5" else float(t), 0.0) for name in ANTS}
        stillness.take(float(t), doings, places)
    assert stillness.stuck() == {}
