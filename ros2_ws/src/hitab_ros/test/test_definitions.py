"""Nodes with two versions of a message do not communicate: the later one finds the other."""

import pytest
from hitab_msgs.msg import AgentStatus
from hitab_msgs.srv import Undo

from hitab_core import HitabError
from hitab_ros import qos
from hitab_ros.nodes import definitions
from hitab_ros.nodes.spinning import make_node
from hitab_ros.testing import context_of_its_own, wait_until

STATUS = "hitab_msgs/msg/AgentStatus"


@pytest.fixture
def two():
    """Two nodes, of which one publishes a status."""
    with context_of_its_own() as context:
        first, second = (make_node(name, context=context) for name in ("first", "second"))
        first.create_publisher(AgentStatus, "lone/status", qos.LATCHED)
        wait_until(
            lambda: second.count_publishers("lone/status") and "first" in second.get_node_names()
        )
        yield first, second
        first.destroy_node()
        second.destroy_node()


def test_nodes_with_the_same_definitions_talk(two):
    first, second = two
    definitions.check_same_message_version(first)
    definitions.check_same_message_version(second)


def test_a_node_that_defines_a_message_differently_is_named(two, monkeypatch):
    other = "RIHS01_" + "0" * 64  # as another version's would be
    monkeypatch.setattr(definitions, "own_hash", lambda kind: other)
    with pytest.raises(HitabError, match="another version of HiTAB") as refused:
        definitions.check_same_message_version(two[1])
    assert str(refused.value).startswith(f"/first defines {STATUS} differently")


@pytest.mark.parametrize("part", ["Request", "Response"])
def test_a_node_that_defines_a_service_differently_is_named(two, monkeypatch, part):
    first, second = two
    first.create_service(Undo, "lone/undo", lambda request, response: response)
    wait_until(lambda: "/lone/undo" in dict(second.get_service_names_and_types()))
    definitions.check_same_message_version(second)

    own, other = definitions.own_hash, "RIHS01_" + "0" * 64
    changed = f"hitab_msgs/srv/Undo_{part}"
    monkeypatch.setattr(definitions, "own_hash", lambda k: other if k == changed else own(k))
    with pytest.raises(HitabError) as refused:
        definitions.check_same_message_version(second)
    assert str(refused.value).startswith(f"/first defines {changed} differently")
