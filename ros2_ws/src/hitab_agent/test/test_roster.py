"""A roster tells whom a host runs; one that cannot be used is refused with the way out."""

import json
import time
from functools import partial
from types import SimpleNamespace

import pytest
import rclpy
from hitab_msgs import msg
from rclpy.parameter import Parameter

from hitab_agent.host import roster_topic
from hitab_agent.host.roster import read_roster
from hitab_agent.host.roster_topic import RosterTopic
from hitab_agent.scheduler import Scheduler
from hitab_core.texts.errors import HitabError
from hitab_ros import (
    FinalError,
    HostRosters,
    Lease,
    check_name_is_free,
    give_signs_of_life,
    names,
    qos,
)
from hitab_ros.leases import NO_LEASE
from hitab_ros.nodes.guarded_node import GuardedNode


def read(process, folder, roster):
    file = folder / "roster.json"
    file.write_text(json.dumps(roster))
    host = rclpy.create_node(
        "host",
        context=process.node.context,
        parameter_overrides=[Parameter("roster", value=str(file))],
        use_global_arguments=False,
    )
    process.add(host)
    return read_roster(host)


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ({"parameters": {}}, "name"),
        ({"name": 3}, "3 must be a name"),
        ({"name": "a", "parameters": ["seed"]}, "parameters .*'seed'.* a mapping"),
        ({"name": "a", "node": "os:path"}, '"os:path" is not a subclass'),
        ({"name": "a", "node": "nowhere:Node"}, "nowhere"),
        ({"name": "a", "parametres": {}}, "parametres"),
        ("a", "str"),
    ],
)
def test_a_roster_that_cannot_be_used_is_refused_by_file(process, tmp_path, entry, why):
    with pytest.raises(HitabError, match=rf"roster.json: not a roster of agents: .*{why}"):
        read(process, tmp_path, [entry])


def desk_of(process, name):
    desk = GuardedNode("host", namespace=f"/host_of_{name}", context=process.node.context)
    process.add(desk)
    return desk


def roster_of(desk, agents, lease=NO_LEASE, give_up=None, lives=True):
    if lives:
        give_signs_of_life(desk, "red-1")
    rosters = HostRosters(desk, f"/{names.HOSTS}", leases=bool(lease.number))
    return RosterTopic(desk, agents, "red-1", rosters, Scheduler(desk), lease, give_up)


def test_an_agent_that_runs_in_another_host_does_not_start_and_of_two_at_once_both_say_so(
    process,
):
    agents = [SimpleNamespace(agent_name=name) for name in ("a", "b", "c")]
    one, other = desk_of(process, "a"), desk_of(process, "b")
    rosters = [
        roster_of(desk, theirs) for desk, theirs in ((one, agents[:2]), (other, agents[1:]))
    ]
    for roster in rosters:
        roster.publish()
    for desk, host in ((one, "host_of_b"), (other, "host_of_a")):
        process.until(lambda desk=desk: desk.guard.faults)
        assert f"b also run in {host}; stop one" in desk.guard.faults.texts()[0]
    rosters[1]._nodes = agents[2:]
    rosters[1].publish()
    process.until(lambda: not one.guard.faults)

    late = GuardedNode("agent", namespace="/c", context=process.node.context)
    process.add(late)
    with pytest.raises(HitabError, match='"c" is already running in swarm red-1'):
        check_name_is_free(process.spinner(), [late], msg.AgentStatus, observer=process.node)


SENTENCE = "host_2 runs on lab_3 now (lease 2); this one yields"


@pytest.mark.parametrize("order", [("lab_1", "lab_3"), ("lab_3", "lab_1")])
def test_of_two_hosts_of_the_same_agents_the_one_with_the_older_lease_yields(process, order):
    agents = [SimpleNamespace(agent_name=name) for name in ("a", "b")]
    leases = {"lab_1": Lease("lab_1", 1, "host_2"), "lab_3": Lease("lab_3", 2, "host_2")}
    gave_up = []
    for machine in order:
        desk = desk_of(process, names.of_host("a", machine))
        roster_of(
            desk, agents, leases[machine], lambda why, m=machine: gave_up.append((m, why))
        ).publish()
    process.until(lambda: gave_up)
    assert {*gave_up} == {("lab_1", SENTENCE)}
    assert not desk.guard.faults


def test_a_roster_stops_no_host_until_its_own_gives_a_sign_of_life(process):
    agents = [SimpleNamespace(agent_name="a")]
    gave_up = []
    mine = roster_of(desk_of(process, "a"), agents, Lease("lab_1", 1, "host_2"), gave_up.append)
    mine.publish()
    stray = desk_of(process, "stray")
    publisher = stray.create_publisher(msg.HostRoster, f"/{names.HOSTS}", qos.LATCHED)
    found = {"agents": ["a"], "swarm": "red-1", "machine": "lab_3", "lease": 99}
    later = mine.number + 10**9
    publisher.publish(msg.HostRoster(host="host_of_a", number=later, **found))
    process.until(lambda: mine.number > later)  # its own name is taken back
    heard = list[msg.Alive]()
    process.node.create_subscription(msg.Alive, f"/{names.ALIVE}", heard.append, qos.SIGNS_OF_LIFE)
    publisher.publish(msg.HostRoster(host="host_of_stray", number=later, **found))
    process.until(lambda: len(heard) > 3)
    assert gave_up == []
    give_signs_of_life(stray, "red-1")
    # The number of the stray roster in its name does not make its own ones old.
    process.until(lambda: gave_up)


@pytest.mark.parametrize("lives", [True, False])
@pytest.mark.parametrize("number", [1, 3])
def test_a_host_does_not_start_if_a_newer_lease_has_its_names_and_starts_if_an_older_one_has(
    process, number, lives
):
    agents = [SimpleNamespace(agent_name="a")]
    roster_of(desk_of(process, "other"), agents, Lease("lab_3", 2), None, lives).publish()
    late = GuardedNode(
        "agent",
        namespace="/a",
        context=process.node.context,
        parameter_overrides=[Parameter("swarm", value="red-1")],
    )
    late.declare_parameter("swarm", "")
    process.add(late)
    check = partial(
        check_name_is_free,
        *(process.spinner(), [late], msg.AgentStatus),
        observer=process.node,
        lease=Lease("lab_1", number, "host_2"),
    )
    if number == 3 or not lives:
        check()
        return
    with pytest.raises(FinalError) as refused:
        check()
    assert str(refused.value) == SENTENCE


@pytest.mark.parametrize("hours", [-0.5, 0.0])
def test_a_clock_that_was_set_back_makes_no_roster_older_than_the_one_before(
    process, tmp_path, monkeypatch, hours
):
    agents = [SimpleNamespace(agent_name="a")]
    listener = HostRosters(process.node, f"/{names.HOSTS}")
    numbers = []
    for start in range(2):
        roster = roster_of(desk_of(process, f"start_{start}"), agents)
        roster._name = "host_of_a"
        roster.remember(tmp_path)
        roster.publish()
        process.until(
            lambda n=roster.number: n in {one.number for one in listener.rosters.values()}
        )
        numbers.append(roster.number)
        now = time.time_ns()
        clock = SimpleNamespace(time_ns=lambda now=now: now + int(hours * 3600e9))
        monkeypatch.setattr(roster_topic, "time", clock)
    assert numbers[1] > numbers[0]
