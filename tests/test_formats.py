"""Files that earlier versions wrote still load; see tests/data/formats/README.md."""

import json
import shutil
from pathlib import Path

import pytest
from mcap.writer import Writer

from hitab_bringup import parse_swarm, read_swarm
from hitab_client import DescriptionError, LessonError, SwarmError
from hitab_client.bootstrapping import read_generations
from hitab_client.lessons import read_lesson
from hitab_commander import read_kind
from hitab_core import VocabularyError
from hitab_studio.replay import Recording
from keepaway_world.world import KeepawayWorld

FORMATS = Path(__file__).parent / "data" / "formats"


def test_a_lesson_from_before_loads():
    lesson = read_lesson(FORMATS / "lessons" / "control_ball.yaml")
    assert (lesson.name, lesson.agent) == ("ControlBall", "keeper_1")
    assert lesson.steps


def test_a_swarm_description_from_before_loads():
    swarm = read_swarm(FORMATS / "swarms" / "keepaway.yaml")
    assert swarm.agent_names == ("keeper_1", "keeper_2", "keeper_3")
    assert swarm.world is not None


def test_generations_from_before_are_read(tmp_path):
    shutil.copy(FORMATS / "generations.yaml", tmp_path / "Keepaway.yaml")
    known = read_generations(tmp_path, "keeper_1", "Keepaway")

    assert known.current == 3
    assert [(g.number, g.parent, g.restored) for g in known.all] == [
        (1, 0, ()),
        (2, 1, (4,)),
        (3, 2, (5,)),
    ]
    assert str(known.best().score.figures["seconds"]) == "27.89 ± 4.14"
    assert known.get(2).restart.wait.describe() == "keeper_2 has said something"


def test_a_snapshot_of_a_world_from_before_is_restored():
    snapshot = json.loads((FORMATS / "world.json").read_text())
    world = KeepawayWorld()
    world.restore(snapshot)

    assert (world.seed, world.cycle) == (3, 5)
    assert world.snapshot() == snapshot


def test_a_recording_from_before_is_replayed():
    recording = Recording(FORMATS / "keepaway.mcap")

    assert recording.seconds > 0.0
    assert sorted(recording.statuses(recording.seconds)) == ["keeper_1", "keeper_2", "keeper_3"]
    scene = recording.scene(0.0)
    assert {"ball", "keeper_1", "taker_1"} <= set(scene.names)
    # It is from before worlds declared looks, which changed the definition of the state.
    assert {look.shape for look in scene.looks.values()} == {"disc"}


def test_a_recording_shows_the_same_moments_back_and_forth():
    recording = Recording(FORMATS / "keepaway.mcap")
    moments = (0.0, recording.seconds, 0.9 * recording.seconds)
    cycles = [recording.scene(at).cycle for at in moments]
    assert cycles[0] < cycles[2] < cycles[1]
    assert [recording.scene(at).cycle for at in reversed(moments)] == cycles[::-1]
    assert recording.statuses(recording.seconds)["keeper_1"].cycle > 0
    assert recording.statuses(-1.0) == {}


def test_a_swarm_description_of_a_newer_format_is_refused_before_anything_else_in_it():
    text = "swarm: new\nformat: 3\nsomething: new\n"
    with pytest.raises(DescriptionError) as refused:
        parse_swarm(text, Path("new.yaml"))
    assert str(refused.value).endswith(
        "has format version 3, but this HiTAB reads up to 2; update HiTAB"
    )
    assert "new.yaml:2" in str(refused.value)
    assert "something" not in str(refused.value)


def test_lessons_and_kinds_of_a_newer_format_are_refused(tmp_path):
    lesson, kind = tmp_path / "lesson.yaml", tmp_path / "commander.yaml"
    lesson.write_text("lesson: New\nformat: 3\n")
    kind.write_text("commander: New\nformat: 2\n")
    with pytest.raises(LessonError, match=r"lesson.yaml:2.*has format version 3"):
        read_lesson(lesson)
    with pytest.raises(VocabularyError, match=r"commander.yaml:2.*has format version 2"):
        read_kind(kind)


def test_files_may_name_their_format(tmp_path):
    text = (FORMATS / "lessons" / "control_ball.yaml").read_text()
    (tmp_path / "lesson.yaml").write_text("format: 1\n" + text)
    assert read_lesson(tmp_path / "lesson.yaml").name == "ControlBall"


def test_a_recording_of_a_newer_format_is_refused(tmp_path):
    path = tmp_path / "new.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="hitab_studio")
        writer.add_metadata("hitab", {"format": "2"})
        writer.finish()
    with pytest.raises(SwarmError, match=r"new.mcap has format version 2"):
        Recording(path)


@pytest.mark.parametrize(
    ("encoding", "text", "message"),
    [
        ("ros2msg", b"no definition at all", "its definition of hitab_msgs/msg/WorldState is"),
        ("ros2idl", b"", 'is "ros2idl", not "ros2msg"'),
    ],
)
def test_a_recording_whose_messages_cannot_be_understood_is_refused(
    tmp_path, encoding, text, message
):
    path = tmp_path / "strange.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="somebody's")
        schema = writer.register_schema("hitab_msgs/msg/WorldState", encoding, text)
        channel = writer.register_channel("/world/state", "cdr", schema)
        writer.add_message(channel, log_time=0, data=b"", publish_time=0)
        writer.finish()
    with pytest.raises(SwarmError, match=r"strange\.mcap cannot be read") as refused:
        Recording(path)
    assert message in str(refused.value)
