"""A bag has what ``ros2 bag`` looks for in it; what is no sound bag is refused in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hitab_msgs import msg
from hitab_msgs.srv import BeginTraining, EditExamples
from mcap.writer import Writer
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from hitab_client.errors import SwarmError
from hitab_client.recording import (
    definition,
    message_class,
    session_of,
    type_name,
)
from hitab_client.recording.bag_file import BagFile
from hitab_ros import own_hash, qos, session_topics

REQUEST = BeginTraining.Request(automaton="Near", features=["DistanceTo(ball)"], request=2**63)


def write(path: Path, messages: dict[str, Any]) -> None:
    """Write one message per topic, sent one after the other."""
    bag = BagFile(path)
    for at, (topic, message) in enumerate(messages.items()):
        kind = type_name(type(message))
        profile = qos.LATCHED if topic.endswith("status") else qos.EVENTS
        channel = bag.add_topic(topic, kind, [profile], own_hash(kind))
        bag.write(channel, serialize_message(message), received=2000 + at, sent=1000 + at)
    bag.close()


def session() -> dict[str, Any]:
    request = session_topics.request_text("begin", REQUEST)
    return {
        "/one/known": msg.Distribution(source="one", digest="d"),
        "/one/status": msg.AgentStatus(agent="one", domain="keepaway"),
        "/one/requested": String(data=request),
        "/one/perceived": msg.Percept(sequence=7, values=[1.5]),
    }


def test_a_request_is_read_as_it_was_written() -> None:
    edit = EditExamples.Request(action=EditExamples.Request.RETIME, numbers=[1, 4], ago=0.1 + 0.2)
    for service, request in (("begin", REQUEST), ("edit_examples", edit)):
        text = session_topics.request_text(service, request)
        assert session_topics.request_of(text) == (service, request)
    other = '{"service": "reboot", "request": {}}'
    for wrong in ("", "[]", other, text.replace("ago", "then"), text.replace("[1, 4]", "4")):
        with pytest.raises(ValueError, match="is no request to an agent"):
            session_topics.request_of(wrong)


def test_a_session_is_read_in_the_order_in_which_it_was_sent(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", session())
    for name in ("one", "/one"):
        found = session_of(tmp_path / "a.mcap", name)
        assert (found.agent, found.domain, found.known.digest) == ("one", "keepaway", "d")
        assert [name for _, name, _ in found.sent] == [
            "known",
            "status",
            "requested",
            "perceived",
        ]


def refusal(path: Path, agent: str = "one") -> str:
    with pytest.raises(SwarmError) as refused:
        session_of(path, agent)
    text = str(refused.value)
    assert "\n" not in text
    return text


def test_what_is_no_recording_is_refused_and_what_would_be_one_is_named(tmp_path: Path) -> None:
    whole = tmp_path / "whole.mcap"
    write(whole, session())
    data = whole.read_bytes()
    cut = [data[:size] for size in (len(data) - 1, len(data) // 2, 20, 8)]
    for content in (*cut, b"SQLite format 3\0", b"", b"#ROSBAG V2.0\n"):
        (tmp_path / "other.mcap").write_bytes(content)
        assert "other.mcap is no complete MCAP recording" in refusal(tmp_path / "other.mcap")
    assert "absent.mcap cannot be read" in refusal(tmp_path / "absent.mcap")
    assert "cannot be read" in refusal(tmp_path)


def test_a_damaged_recording_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    write(path, session())
    data = bytearray(path.read_bytes())
    data[60:90] = b"\xff" * 30
    path.write_bytes(bytes(data))
    assert "a.mcap cannot be read" in refusal(path)


def test_messages_with_another_definition_are_not_trained_from(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="another version")
        for topic, message in session().items():
            kind = type_name(type(message))
            text = definition(kind) + ("\nuint8 more" if topic == "/one/perceived" else "")
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            channel = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channel, 1, serialize_message(message), 1)
        writer.finish()
    refused = refusal(path)
    assert "hitab_msgs/msg/Percept on /one/perceived" in refused
    assert "use the version of HiTAB that recorded it" in refused


def test_a_type_that_is_not_installed_is_refused_with_its_package() -> None:
    with pytest.raises(SwarmError, match="install the ROS package nowhere_msgs"):
        message_class("nowhere_msgs/msg/Thing")
    assert message_class("hitab_msgs/msg/Percept") is msg.Percept
