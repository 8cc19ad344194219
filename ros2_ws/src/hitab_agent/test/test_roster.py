"""A roster tells whom a host runs; one that cannot be used is refused with the way out."""

import json
from types import SimpleNamespace

import pytest
import rclpy
from hitab_msgs import msg
from rclpy.parameter import Parameter

from hitab_agent.host.roster import read_roster
from hitab_agent.host.roster_topic import RosterTopic
from hitab_agent.scheduler import Scheduler
from hitab_core.texts.errors import HitabError
from hitab_ros import HostRosters, check_name_is_free, names
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


def test_an_agent_that_runs_in_another_host_does_not_start_and_of_two_at_once_both_say_so(
    process,
):
    agents = [SimpleNamespace(agent_name=name) for name in ("a", "b", "c")]
    one, other = desk_of(process, "a"), desk_of(process, "b")
    rosters = [
        RosterTopic(desk, theirs, "red-1", HostRosters(desk, f"/{names.HOSTS}"), Scheduler(desk))
        for desk, theirs in ((one, agents[:2]), (other, agents[1:]))
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
