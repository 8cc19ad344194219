"""Bags have the metadata that ``ros2 bag`` expects; damaged bags are refused in one line."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random
from typing import Any

import pytest
import zstandard
from hitab_msgs import msg
from mcap.writer import CompressionType, IndexType, Writer
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

ZSTD = zstandard.ZstdCompressor()


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


def test_what_is_no_recording_is_refused_with_what_converts_it(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    for content in (b"SQLite format 3\0", b"", b"#ROSBAG V2.0\n", ZSTD.compress(b"a bag")):
        path.write_bytes(content)
        assert "other.mcap is no MCAP recording; `ros2 bag convert`" in refusal(path)
    assert "absent.mcap cannot be read: No such file" in refusal(tmp_path / "absent.mcap")
    path.unlink()
    assert "is a folder without an MCAP file" in refusal(tmp_path)


COUNT = 150


def driven(path: Path, **options: Any) -> list[Any]:
    """Write a keeper's percepts and actions with mcap's own writer; return the expected moments.

    Options change ``data`` and ``when`` of each message, and the writer's own settings.
    """
    data = options.pop("data", bytes)
    when = options.pop("when", int)
    comment = options.pop("comment", "")
    with path.open("wb") as file:
        writer = Writer(file, **{"chunk_size": 2000, "repeat_schemas": False, **options})
        writer.start(profile="ros2", library="rosbag2")
        channels = {}
        for topic, message in session().items():
            kind = type_name(type(message))
            text = f"{comment}\n{definition(kind)}".encode()
            schema = writer.register_schema(kind, "ros2msg", text)
            metadata = {} if comment else {"topic_type_hash": own_hash(kind)}
            channels[topic] = writer.register_channel(topic, "cdr", schema, metadata)
        for number in range(COUNT):
            sent: dict[str, Any] = session() if number == 0 else {}
            sent["/one/perceived"] = msg.Percept(sequence=number, values=[number / 7])
            sent["/world/actions"] = msg.Action(agent="one", sequence=number, values=[number / 9])
            for at, (topic, message) in enumerate(sent.items()):
                stamp = when(10**18 + number * 10**8 + at * 10**7)
                writer.add_message(channels[topic], stamp, data(serialize_message(message)), stamp)
        writer.finish()
    return [(number / 10, [number / 7], [number / 9]) for number in range(COUNT)]


def read(path: Path) -> tuple[list[Any], str]:
    found = driving_of(path, "one")
    done = [(round(m.when, 1), list(m.values), list(m.did or ())) for m in found.moments]
    return done, found.missing


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"data": lambda data: ZSTD.compress(data)},
        {"compression": CompressionType.LZ4},
        {"use_chunking": False, "compression": CompressionType.NONE},
        {"index_types": IndexType.NONE, "use_statistics": False},
        {"comment": "# worded otherwise in another release"},
        {"when": lambda time: time - (3600 * 10**9 if time % 10**11 > 3 * 10**9 else 0)},
        {"when": lambda time: 2**64 - 1 if time == 10**18 + 3 * 10**9 else time},
    ],
    ids=[
        "plain",
        "message-mode",
        "lz4",
        "unchunked",
        "unindexed",
        "humble",
        "set-back",
        "rollover",
    ],
)
def test_a_bag_is_read_in_the_order_of_its_log(tmp_path: Path, options: dict[str, Any]) -> None:
    right = driven(tmp_path / "a.mcap", **options)
    done, missing = read(tmp_path / "a.mcap")
    assert [one[1:] for one in done] == [one[1:] for one in right]
    times = [one[0] for one in done]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(right[-1][0], abs=0.2)  # but for the moment of the jump
    assert missing == ""


def test_the_folder_of_a_bag_is_read_file_by_file(tmp_path: Path) -> None:
    driven(tmp_path / "bag_10.mcap", when=lambda time: time + 15 * 10**9)
    right = driven(tmp_path / "bag_9.mcap")
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    done, _ = read(tmp_path)
    assert [one[1:] for one in done] == [one[1:] for one in right * 2]
    assert done[-1][0] == pytest.approx(29.9)


def test_an_unfinished_recording_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    right = driven(path)
    whole = path.read_bytes()
    for end in (b"", bytes(4096)):  # killed, or a power cut
        path.write_bytes(whole[: len(whole) // 2] + end)
        done, missing = read(path)
        assert 0 < len(done) < COUNT
        assert done[:-1] == right[: len(done) - 1]  # the last action may be lost
        assert "a.mcap is not finished:" in missing
        assert f"of {path.stat().st_size}. Its recorder was killed" in missing
    path.write_bytes(whole[:20])
    assert "0 messages were read, up to byte 0 of 20" in refusal(path)


def test_a_damaged_recording_is_refused_with_a_way_to_read_what_is_before(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    right = driven(path)
    content = bytearray(path.read_bytes())
    half = len(content) // 2
    content[half : half + 300] = bytes(300)
    path.write_bytes(content)
    way_out = re.search(r"or read what is before: `head -c (\d+) (.*) > part.mcap`", refusal(path))
    assert way_out is not None
    part = tmp_path / "part.mcap"
    part.write_bytes(Path(way_out[2]).read_bytes()[: int(way_out[1])])
    done, missing = read(part)
    assert done[:-1] == right[: len(done) - 1]
    assert len(done) > 5
    assert "part.mcap is not finished" in missing


def test_whatever_is_wrong_in_a_recording_it_is_read_right_or_refused(tmp_path: Path) -> None:
    path, random = tmp_path / "a.mcap", Random(5)
    right = driven(path)
    whole = path.read_bytes()
    for number in range(250):
        content = bytearray(whole)
        if number % 3:
            content[random.randrange(len(content))] ^= 1 << random.randrange(8)
        else:
            del content[random.randrange(len(content)) :]
        path.write_bytes(content)
        try:
            done, missing = read(path)
        except SwarmError:
            continue
        assert done[:-1] == right[: len(done) - 1]
        assert missing or done == right


def test_a_record_whose_kind_is_damaged_is_not_skipped_in_silence(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    right = driven(path)
    whole, at, refused = path.read_bytes(), 8, 0
    while at < len(whole) - 8:
        content = bytearray(whole)
        content[at] ^= 0x80  # record types from 0x80 on are private, and readers skip them
        path.write_bytes(content)
        try:
            assert read(path)[0] == right
        except SwarmError:
            refused += 1
        at += 9 + int.from_bytes(whole[at + 1 : at + 9], "little")
    assert refused


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
