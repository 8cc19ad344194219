"""A bag has what ``ros2 bag`` looks for in it; what is no sound bag is refused in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hitab_msgs import msg
from mcap.writer import Writer
from rclpy.serialization import serialize_message

from hitab_client.errors import SwarmError
from hitab_client.recording import (
    definition,
    driving_of,
    message_class,
    type_name,
)
from hitab_client.recording.bag_file import BagFile
from hitab_ros import own_hash, qos


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
    return {
        "/world/status": msg.WorldStatus(world="keepaway"),
        "/one/status": msg.AgentStatus(agent="one", domain="keepaway"),
        "/one/perceived": msg.Percept(sequence=7, values=[1.5]),
        "/world/actions": msg.Action(agent="one", sequence=7, values=[0.5]),
    }


def test_the_name_of_an_agent_may_have_its_namespace(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", session())
    for name in ("one", "/one", ""):
        found = driving_of(tmp_path / "a.mcap", name)
        assert (found.agent, found.domain) == ("one", "keepaway")
        assert [(list(m.values), list(m.did or ())) for m in found.moments] == [([1.5], [0.5])]


def refusal(path: Path, agent: str = "one") -> str:
    with pytest.raises(SwarmError) as refused:
        driving_of(path, agent)
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


def test_messages_with_another_definition_are_not_read(tmp_path: Path) -> None:
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
