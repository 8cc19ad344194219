"""`rosbags`, which shares no code with the recorder, reads whole recordings."""

from __future__ import annotations

from pathlib import Path

from hitab_msgs import msg
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosbags.interfaces import ConnectionExtRosbag2, QosDurability, QosReliability

from hitab_client.recording import type_name
from hitab_client.recording.bag_file import BagFile
from hitab_ros import own_hash, qos

MESSAGES = {
    "/one/command": (msg.Command(behavior="Go"), qos.EVENTS),
    "/one/status": (msg.AgentStatus(agent="one", active_path=["Go", "Stop"]), qos.LATCHED),
    "/one/perceived": (msg.Percept(sequence=7, values=[0.1, 1.5]), qos.CYCLE),
}


def test_a_bag_is_read_by_another_reader(tmp_path: Path) -> None:
    bag = BagFile(tmp_path / "bag.mcap")
    for at, (topic, (message, profile)) in enumerate(MESSAGES.items()):
        kind = type_name(type(message))
        channel = bag.add_topic(topic, kind, [profile], own_hash(kind))
        bag.write(channel, serialize_message(message), received=2000 + at, sent=1000 + at)
    bag.close()

    with AnyReader([bag.path]) as reader:
        found = {
            connection.topic: (at, reader.deserialize(data, connection.msgtype))
            for connection, at, data in reader.messages()
        }
        offered = {
            connection.topic: connection.ext.offered_qos_profiles[0]
            for connection in reader.connections
            if isinstance(connection.ext, ConnectionExtRosbag2)
        }
    assert [at for at, _ in found.values()] == [2000, 2001, 2002]
    assert list(found["/one/status"][1].active_path) == ["Go", "Stop"]
    assert list(found["/one/perceived"][1].values) == [0.1, 1.5]
    assert set(offered) == set(MESSAGES)
    assert offered["/one/status"].durability is QosDurability.TRANSIENT_LOCAL
    assert offered["/one/command"].durability is QosDurability.VOLATILE
    assert {one.reliability for one in offered.values()} == {QosReliability.RELIABLE}
