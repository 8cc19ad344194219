"""With no swarm up, a verb at once reports known swarms, searches briefly, and names a remedy."""

import subprocess
import sys

import pytest
from hitab_msgs.msg import AgentStatus

from hitab_cli.main import make_app
from hitab_cli.verbs.verb_connection import connection
from hitab_client import RosLink, SwarmError, domain_ids, swarm_choice
from hitab_client.connecting.identity import new_identity
from hitab_ros import qos

ERROR = "error: no swarm answers in ROS domain {}\n  start keepaway: `hitab up keepaway`"
CALLS = {
    "demonstrate keeper_1 Stop",
    "perform keeper_1 Stop",
    "distribute keeper_1 A",
    "vocabulary keeper_1",
    "train keeper_1 A",
    "test keeper_1",
    "undo keeper_1",
    "save keeper_1",
    "examples keeper_1",
    "status",
    "status --json -",
    "tree",
    "order captain Stop",
    "world pause",
    "world place ball x=1",
    "lesson run approach_ball",
    'bootstrap next keeper_1 --wait {"said":keeper_2} --within 20',
}


@pytest.fixture(autouse=True)
def nothing_up(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield tmp_path


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(swarm_choice, "FOUND_S", 0.01)


def test_verbs_that_need_a_swarm_fail_with_the_remedy(impatient, capfd):
    for call in sorted(CALLS):
        with pytest.raises(SystemExit) as ended:
            make_app()(call.split())
        printed = capfd.readouterr()
        assert (ended.value.code, printed.out) == (1, ""), call
        first, *rest = printed.err.splitlines()
        assert first.startswith("No swarm runs in ROS domain "), call
        assert "\n".join(rest) == ERROR.format(domain_ids.chosen_by_user()), call


def test_what_the_registry_knows_is_said_before_ros_is_loaded(nothing_up):
    script = (
        "import sys\nsys.modules['rclpy'] = None\n"
        "from hitab_cli.verbs.verb_connection import connection\n"
        "with connection(): pass\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.stderr.startswith("No swarm runs in ROS domain ")
    assert "ModuleNotFoundError: import of rclpy halted" in done.stderr


def test_nodes_that_were_started_by_hand_are_found(monkeypatch):
    number = domain_ids.chosen_by_user()
    monkeypatch.setattr(swarm_choice, "FOUND_S", 0.01)
    with RosLink(number) as agent, RosLink(number) as link:
        with pytest.raises(Exception, match="no swarm answers in ROS domain"):
            swarm_choice.look_elsewhere(link)
        # A subscriber alone is no sign of a swarm.
        link.subscribe(AgentStatus, "/lone/status", lambda _: None, qos.LATCHED)
        with pytest.raises(Exception, match="no swarm answers in ROS domain"):
            swarm_choice.look_elsewhere(link)
        agent.node.create_publisher(AgentStatus, "/lone/status", qos.LATCHED)
        monkeypatch.setattr(swarm_choice, "FOUND_S", 30.0)
        swarm_choice.look_elsewhere(link)


@pytest.fixture
def elsewhere(monkeypatch):
    """Yield the identity of a swarm that this registry does not know, and its status."""
    identity = "red-0a1b2c3d"
    with RosLink(domain_ids.chosen_by_user()) as link:
        status = AgentStatus(agent="lone", mode=AgentStatus.IDLE, swarm=identity)
        publisher = link.node.create_publisher(AgentStatus, "/lone/status", qos.LATCHED)
        publisher.publish(status)
        monkeypatch.setattr(swarm_choice, "FOUND_S", 30.0)
        yield identity, lambda swarm: publisher.publish(AgentStatus(agent="lone", swarm=swarm))


def test_a_swarm_of_another_registry_is_refused_with_the_way_to_it(elsewhere):
    identity, _ = elsewhere
    way = (
        f"lone belongs to swarm {identity}, which was not started from here .* --swarm {identity}"
    )
    with connection() as there, pytest.raises(SwarmError, match=way):
        there.agents.await_agent("lone", 60.0)


def test_a_swarm_of_another_registry_is_used_if_its_identity_is_given(elsewhere):
    identity, _ = elsewhere
    with connection(identity) as there:
        assert there.agents.await_agent("lone", 60.0).swarm == identity
    with (
        connection("blue-0a1b2c3d") as there,
        pytest.raises(SwarmError, match="not to swarm blue"),
    ):
        there.agents.await_agent("lone", 60.0)


@pytest.mark.parametrize("swarm", ["", new_identity("red", launched=True)], ids=["hand", "launch"])
def test_nodes_that_no_registry_knows_are_used_as_they_are(elsewhere, swarm):
    elsewhere[1](swarm)
    with connection() as there:
        assert there.agents.await_agent("lone", 60.0).swarm == swarm
