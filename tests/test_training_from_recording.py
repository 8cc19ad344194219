"""Examples that are made from a recorded session equal those that were made live, bit for bit."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml
from mcap.exceptions import EndOfFile
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from sensor_msgs.msg import LaserScan
from waiting import within

from hitab_bringup.bringing_up import RunningSwarm
from hitab_bringup.from_recording import train_from_recording
from hitab_client.recording import Recorder, opened
from hitab_client.recording.bag_file import BagFile
from hitab_core import HitabError
from hitab_core.library import SUFFIX

ONE = "keeper_1"
AUTOMATON = "RecordedNear"
SECONDS = 60.0


def put(swarm: RunningSwarm, distance: float) -> None:
    """Put the keeper so far from the ball, which lies ahead, and let it see that."""
    places = {
        ONE: {"x": -distance, "y": 0.1, "heading": 0.0, "vx": 0.0, "vy": 0.0},
        "ball": {"x": 0.0, "y": 0.0, "vx": 0.0, "vy": 0.0},
        "taker_1": {"x": -9.0, "y": 9.0},
        "taker_2": {"x": -8.0, "y": 9.0},
    }
    swarm.world.shown(swarm.world.place(places))


def train(swarm: RunningSwarm, look: Any) -> None:
    """Train with all that a person can do: late commands, tests, corrections, undo and answers."""
    agents, world = swarm.agents, swarm.world
    put(swarm, 8.3)
    agents.command(ONE, "GoFast")
    world.step(10)
    agents.command(ONE, "GoSlow", ago=0.4)
    look()
    world.step(5)
    agents.command(ONE, "Stop")
    agents.command(ONE, "Pass")
    agents.undo(ONE)
    agents.set_mode(ONE, "testing", restart=True)
    put(swarm, 6.1)
    world.step(8)
    agents.set_mode(ONE, "training")
    agents.command(ONE, "GoMedium")
    world.step(3)
    agents.command(ONE, "GoMedium")
    agents.relabel(ONE, [4], "GoMedium")
    agents.retime(ONE, [1], 0.0)
    for question in agents.training(ONE, searched=True).questions[:1]:
        agents.answer(ONE, question.number)
    agents.set_mode(ONE, "testing")
    world.step(10)
    agents.set_mode(ONE, "training")


@dataclass
class Recorded:
    path: Path
    live: dict[str, Any]
    examples: int


def content(folder: Path) -> dict[str, Any]:
    """Return all of a behavior's file but when and from what it was saved."""
    text = (folder / f"{AUTOMATON}{SUFFIX}").read_text(encoding="utf-8")
    whole = dict(yaml.safe_load(text))
    del whole["checksum"], whole["provenance"]
    return whole


@pytest.fixture(scope="module")
def recorded(keepers: RunningSwarm, tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    agents = keepers.agents
    if agents.statuses[ONE].mode in ("training", "testing"):
        agents.discard(ONE)
    recorder = Recorder(keepers.link, tmp_path_factory.mktemp("bag") / "session.mcap")

    def heard() -> bool:
        recorder.look()
        return f"/{ONE}" in recorder.sessions and not recorder.awaited

    assert keepers.link.spin_until(heard, SECONDS)
    agents.begin(ONE, AUTOMATON, features=["DistanceTo(ball)", "SecondsInState"])
    train(keepers, recorder.look)
    saved = agents.save(ONE)
    keepers.link.spin_until(lambda: agents.statuses[ONE].mode == "idle", SECONDS)
    keepers.link.spin(0.2)
    recorder.close()
    assert recorder.problem == ""
    there = content(Path(saved.path).parent)
    return Recorded(recorder.bag.path, there, len(there["examples"]))


def test_examples_from_a_recording_equal_those_made_live(
    recorded: Recorded, tmp_path: Path
) -> None:
    folder = tmp_path / "library"
    agent, done, unsaved = train_from_recording(recorded.path, folder, ONE)
    assert agent == ONE
    assert done.saved == [AUTOMATON]
    assert done.commands == 6
    assert done.compared > 10
    assert unsaved is None
    assert recorded.examples > 6
    assert content(folder) == recorded.live


def changed(recorded: Recorded, path: Path, change: Callable[[str, int, bytes], Any]) -> Path:
    """Write a recording again; ``change`` gets the topic, the number and the data of a message.

    It returns the data to write, or None to leave it out.
    """
    bag, channels, numbers = BagFile(path), dict[str, int](), dict[str, int]()
    with opened(recorded.path) as messages:
        for message in messages:
            topic = message.topic
            numbers[topic] = numbers.get(topic, 0) + 1
            data = change(topic, numbers[topic], message.data)
            if data is None:
                continue
            if topic not in channels:
                kind = message.schema.name
                channels[topic] = bag.add_topic(topic, kind, [], message.type_hash)
            bag.write(channels[topic], data, message.received, message.sent)
    bag.close()
    return path


def test_a_percept_that_is_missing_is_noticed(recorded: Recorded, tmp_path: Path) -> None:
    path = changed(
        recorded,
        tmp_path / "gap.mcap",
        lambda topic, number, data: None if topic == f"/{ONE}/perceived" and number == 9 else data,
    )
    with pytest.raises(HitabError, match="percepts are missing between cycle"):
        train_from_recording(path, tmp_path / "library", ONE)


def test_what_was_recorded_is_on_disk_when_the_recorder_is_killed(
    keepers: RunningSwarm, tmp_path: Path
) -> None:
    bag = tmp_path / "killed.mcap"

    def recorded() -> set[str]:
        topics: dict[int, str] = {}
        found = set()
        with bag.open("rb") as file, suppress(EndOfFile):
            for record in StreamReader(file).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message):
                    found.add(topics[record.channel_id])
        return found

    wanted = {"/world/status", *(f"/{agent}/status" for agent in keepers.record.agents)}
    command = [sys.executable, "-m", "hitab_bringup.main", "record", "-o", str(bag)]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as recorder:
        try:
            assert within(SECONDS, lambda: bag.exists() and wanted <= recorded())
        finally:
            recorder.kill()
    assert wanted <= recorded()


def test_the_command_records_chosen_topics_too_and_trains_from_what_it_recorded(
    recorded: Recorded,
    keepers: RunningSwarm,
    hitab: Callable[..., Any],
    tmp_path: Path,
) -> None:
    bag, library = tmp_path / "bag.mcap", tmp_path / "library"
    scans = keepers.link.node.create_publisher(LaserScan, "/robot_1/scan", 10, temporary=True)
    done: list[Any] = []
    options = ("-t", "/robot_1/scan", "-t", "robot_1/odom", "--seconds", "4")
    thread = threading.Thread(
        target=lambda: done.append(hitab("record", "-o", str(bag.with_suffix("")), *options))
    )
    thread.start()
    while thread.is_alive():
        scans.publish(LaserScan(ranges=[1.5]))
        keepers.link.spin(0.1)
    keepers.link.node.destroy_publisher(scans)
    assert done[0].returncode == 0, done[0].stderr
    assert f"to {bag}" in done[0].stdout
    assert (
        "the world is paused: nothing changes\n  let the world go on: `hitab world resume`"
        in done[0].stderr
    )
    assert "/robot_1/odom is not in it: nobody has published it" in done[0].stderr
    with opened(bag) as messages:
        assert "/robot_1/scan" in {message.topic for message in messages}
    again = hitab("record", "-o", str(bag))
    assert f"{bag} exists already" in again.stderr

    trained = hitab("library", "from-recording", str(recorded.path), str(library), "-a", ONE)
    assert trained.returncode == 0, trained.stderr
    assert f"saved {AUTOMATON} in {library}" in trained.stdout
    assert "agrees with the recorded one" in trained.stdout
    refused = hitab("library", "from-recording", str(bag), str(library))
    assert f"{library} is not empty" in refused.stderr
