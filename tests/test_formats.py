"""Files that earlier versions wrote still load; see tests/data/formats/README.md."""

import json
import shutil
from pathlib import Path

import pytest
from hitab_msgs.msg import WorldState
from mcap.writer import Writer
from rclpy.serialization import serialize_message

from hitab_bringup import parse_swarm, read_swarm
from hitab_client.bootstrapping import read_generations
from hitab_client.lessons import read_lesson
from hitab_client.recording import type_name
from hitab_client.recording.bag_file import BagFile
from hitab_commander import read_kind
from hitab_core import HitabError
from hitab_ros import own_hash, qos
from hitab_studio.swarm.replay import Recording
from keepaway_world.world import KeepawayWorld

FORMATS = Path(__file__).parent / "data" / "formats"


def test_files_of_each_kind_from_before_are_read(tmp_path):
    lesson = read_lesson(FORMATS / "lessons" / "control_ball.yaml")
    assert (lesson.name, lesson.agent) == ("ControlBall", "keeper_1")
    assert lesson.steps

    swarm = read_swarm(FORMATS / "swarms" / "keepaway.yaml")
    assert swarm.agent_names == ("keeper_1", "keeper_2", "keeper_3")
    assert swarm.world is not None

    shutil.copy(FORMATS / "generations.yaml", tmp_path / "Keepaway.yaml")
    known = read_generations(tmp_path, "Keepaway")
    assert [g.version for g in known] == [1, 2, 3]
    assert str(known[-1].score.figures["seconds"]) == "27.89 ± 4.14"

    snapshot = json.loads((FORMATS / "world.json").read_text())
    world = KeepawayWorld()
    world.restore(snapshot)
    assert world.snapshot() == snapshot


def bag_of_three_cycles(folder):
    bag = BagFile(folder / "a.mcap")
    kind = type_name(WorldState)
    channel = bag.add_topic("/world/state", kind, [qos.LATCHED], own_hash(kind))
    for cycle in range(1, 4):
        second = cycle * 10**9
        bag.write(channel, serialize_message(WorldState(cycle=cycle)), second, second)
        bag.flush()
    return bag


def test_a_recording_shows_the_same_moments_back_and_forth(tmp_path):
    bag = bag_of_three_cycles(tmp_path)
    bag.close()
    recording = Recording(bag.path)
    moments = (0.0, recording.seconds, 0.9 * recording.seconds)
    cycles = [recording.scene(at).cycle for at in moments]
    assert cycles == [1, 3, 2]
    assert [recording.scene(at).cycle for at in reversed(moments)] == cycles[::-1]
    assert recording.statuses(-1.0) == {}
    assert recording.missing == ""
    bag.path.write_bytes(bag.path.read_bytes()[:-8])
    cut = Recording(bag.path)
    assert cut.scene(cut.seconds).cycle == 3


def test_an_unfinished_recording_is_replayed_and_what_it_lacks_is_said(tmp_path):
    bag = bag_of_three_cycles(tmp_path)
    recording = Recording(bag.path)  # as if its recorder had been killed
    assert recording.scene(recording.seconds).cycle == 3
    assert "a.mcap is not finished: 3 messages were read" in recording.missing
    bag.close()


def test_files_of_a_newer_format_are_refused_before_anything_else_in_them(tmp_path):
    files = {
        "swarm.yaml": ("swarm: new\nformat: 3\nsomething: new\n", read_swarm),
        "lesson.yaml": ("lesson: New\nformat: 4\n", read_lesson),
        "commander.yaml": ("commander: New\nformat: 2\n", read_kind),
    }
    for name, (text, read) in files.items():
        (tmp_path / name).write_text(text)
        with pytest.raises(HitabError, match=rf"{name}:2.*has format version \d, .*update HiTAB"):
            read(tmp_path / name)
    assert parse_swarm("swarm: a\nformat: 2\ndomain: keepaway\nagents: {b: {}}\n", tmp_path / "a")


@pytest.mark.parametrize(
    ("version", "encoding", "text", "message"),
    [
        ("2", "ros2msg", b"", r"strange\.mcap has format version 2"),
        ("1", "ros2msg", b"no definition", "hitab_msgs/msg/WorldState .* defined differently"),
    ],
)
def test_a_recording_that_cannot_be_understood_is_refused(
    tmp_path, version, encoding, text, message
):
    path = tmp_path / "strange.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="somebody's")
        writer.add_metadata("hitab", {"format": version})
        schema = writer.register_schema("hitab_msgs/msg/WorldState", encoding, text)
        channel = writer.register_channel("/world/state", "cdr", schema)
        writer.add_message(channel, log_time=0, data=b"", publish_time=0)
        writer.finish()
    with pytest.raises(HitabError, match=message):
        Recording(path)
