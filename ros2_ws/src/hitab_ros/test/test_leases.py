"""All listeners agree on which host holds an agent, in whatever order the rosters come."""

import copy
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import Alive, HostRoster, MachineProcess
from hypothesis import given
from hypothesis import strategies as st

from hitab_ros import HostRosters, Lease, SignsOfLife
from hitab_ros.leases import YIELDED, holders, machine_rank, rank


def roster(host: str, machine: str = "", lease: int = 0, number: int = 1, agents: Any = "a"):
    return HostRoster(host=host, machine=machine, lease=lease, number=number, agents=[*agents])


def listener(*heard: HostRoster, leases: bool = True) -> HostRosters:
    takes = list[Any]()
    node: Any = SimpleNamespace(
        create_subscription=lambda kind, topic, take, qos: takes.append(take)
    )
    rosters = HostRosters(node, "/hosts", leases=leases)
    for one in heard:
        takes[0](copy.deepcopy(one))
        for hear_sign in takes[1:]:
            hear_sign(Alive(process=one.host))
    return rosters


@pytest.mark.parametrize(
    ("first", "then"),
    [
        (roster("x", "lab_2", 2, 1), roster("y", "lab_1", 1, 9)),
        (roster("x", "lab_1", 2, 1), roster("y", "lab_2", 2, 9)),
        (roster("x", "lab_1", 2, 9), roster("y", "lab_1", 2, 1)),
        (roster("x", "lab_2", 1, 1), roster("y", "", 0, 9)),
    ],
    ids=["lease", "machine", "number", "no lease"],
)
def test_the_newer_lease_then_the_machines_name_then_the_later_start_decides(first, then):
    for heard in ((first, then), (then, first)):
        assert listener(*heard).hosts_of["a"] == ("x",)


def test_without_leases_all_who_list_an_agent_may_hold_it():
    heard = (roster("x", number=1), roster("y", "lab_1", 7, number=9))
    assert {*listener(*heard, leases=False).hosts_of["a"]} == {"x", "y"}
    assert listener(*heard, leases=False).believes("stranger", "a")
    assert not listener(*heard).believes("x", "a")


def test_a_host_that_no_longer_lists_an_agent_does_not_hold_it():
    rosters = listener(roster("x", "lab_2", 2, 1, "ab"), roster("y", "lab_1", 1, 1, "ab"))
    assert [*rosters.speaks_for("x")] == ["a", "b"]
    assert [*rosters.speaks_for("y")] == []
    rosters = listener(*rosters.rosters.values(), roster("x", "lab_2", 2, 2, "a"))
    assert rosters.hosts_of == {"a": ("x",), "b": ("y",)}


HOSTS = st.lists(
    st.builds(
        lambda place, lease, number, agents: roster(
            f"host_{place[0]}_on_{place[1]}", place[1], lease, number, sorted(agents)
        ),
        st.tuples(st.integers(1, 2), st.sampled_from(["lab_1", "lab_2", "lab_3"])),
        st.integers(0, 3),
        st.integers(1, 3),
        st.sets(st.sampled_from("abc"), min_size=1),
    ),
    max_size=8,
    unique_by=rank,
)


@given(heard=HOSTS, data=st.data())
def test_all_listeners_agree_whatever_the_order_in_which_they_hear_the_rosters(heard, data):
    one = listener(*heard)
    other = listener(*data.draw(st.permutations(heard)), *heard)
    assert {k: v for k, v in one.hosts_of.items() if v} == {
        k: v for k, v in other.hosts_of.items() if v
    }
    for name in "abc":
        listing = [r for r in one.rosters.values() if name in r.agents]
        held = holders(listing)
        if any(r.lease for r in listing):
            assert len(held) == 1
            assert all(rank(held[0]) < rank(r) for r in listing if r is not held[0])


def test_signs_of_life_come_from_the_holder_of_an_agent():
    takes = list[Any]()
    node: Any = SimpleNamespace(
        create_subscription=lambda kind, topic, take, qos: takes.append(take)
    )
    signs = SignsOfLife(node, "", lambda name, swarm: True, leases=True)
    hear_roster, *hear_sign = takes

    def sign(process: str) -> set[str]:
        signs.last_signs.clear()
        for hear in hear_sign:
            hear(Alive(process=process))
        return {*signs.last_signs}

    hear_roster(roster("old", "lab_1", 1, 9))
    assert sign("old") == {"a"}
    hear_roster(roster("new", "lab_3", 2, 1))
    assert sign("old") == {"a"}, "a roster alone takes nothing away"
    assert sign("new") == {"a"}
    assert sign("old") == set()


def test_a_host_takes_back_what_was_published_in_its_name():
    mine = roster("x", "lab_1", 1, 5, "ab")
    rosters = listener(mine, roster("x", "lab_1", 99, 6, "c"))
    assert rosters.hosts_of["c"] == ("x",)
    rosters = listener(*rosters.rosters.values(), roster("x", "lab_1", 1, 7, "ab"))
    assert rosters.hosts_of == {"a": ("x",), "b": ("x",), "c": ()}


def test_a_host_says_to_whom_it_yields():
    sentence = "host_2 runs on lab_3 now (lease 2); this one yields"
    assert Lease("lab_1", 1, "host_2").why_yield(roster("y", "lab_3", 2)) == sentence


def test_a_machine_that_has_yielded_a_process_does_not_have_it_whatever_its_name():
    gave_up = MachineProcess(lease=2, state=YIELDED)
    has_it = MachineProcess(lease=2, state="running")
    assert machine_rank("lab_2", has_it) < machine_rank("lab_1", gave_up)
    assert machine_rank("lab_2", MachineProcess(lease=3)) < machine_rank("lab_1", has_it)
