"""What somebody did in a recording is labeled, corrected, trained on and performed."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest
import yaml
from geometry_msgs.msg import Twist, Vector3
from hitab_msgs.msg import Action, Percept, WorldStatus
from rclpy.serialization import serialize_message

from hitab_bringup.processes.bringing_up import RunningSwarm
from hitab_client import SwarmError
from hitab_client.recording import Recorder, driving_of, type_name
from hitab_client.recording.bag_file import BagFile
from hitab_core import BehaviorLibrary, Repertoire, TrainingError, VocabularyError
from hitab_core.labeling import Strip
from hitab_core.operations import LoadLibrary, Perform
from hitab_world.inprocess import PolicyPlayer, cycle, perform
from keepaway_world.domain import DOMAIN
from keepaway_world.hand_written import servo
from keepaway_world.parameters import PAPER
from keepaway_world.percept import BALL
from keepaway_world.world import KeepawayWorld

ONE = "keeper_1"
FEATURES = ("DistanceTo(ball)", "DirectionTo(ball)", "BallIsKickable")
STATES = ("GoFast", "GoMedium", "GoSlow", "Stop", "TurnToBall")
SECONDS = 60.0


def write(path: Path, *messages: tuple[str, float, Any]) -> Path:
    """Write a recording of messages, each with its topic and its time, s."""
    bag, channels = BagFile(path), dict[str, int]()
    for topic, seconds, message in sorted(messages, key=lambda one: one[1]):
        if topic not in channels:
            channels[topic] = bag.add_topic(topic, type_name(type(message)), [], "")
        when = int((1000 + seconds) * 1e9)
        bag.write(channels[topic], serialize_message(message), when, when)
    bag.close()
    return path


def program(body: Any) -> str:
    """Go to the ball and stop there, as a program of the user's own; return what it does."""
    distance, direction = body.values[BALL : BALL + 2]
    name = servo(distance, direction, float(body.ball_is_kickable))
    DOMAIN.behaviors[name].pulse(body)
    return name


def driven(path: Path, episodes: int, cycles: int) -> list[str]:
    """Record a program that answers a keeper's percepts; return what it did in each cycle."""
    world = KeepawayWorld(replace(PAPER, taker_speed=0.25), 3)
    did: list[str] = []
    player = PolicyPlayer(DOMAIN.body(ONE), lambda body: did.append(program(body)))
    messages: list[tuple[str, float, Any]] = [
        ("/world/status", 0.0, WorldStatus(world="keepaway", agents=[ONE]))
    ]
    for episode in range(episodes):
        world.reset(episode)
        for first in [True] + [False] * (cycles - 1):
            if world.ended:
                break
            cycle(world, {ONE: player})
            n = len(did)
            seen = Percept(sequence=n, cycle=n, values=player.body.values, restart=first)
            act = Action(agent=ONE, sequence=n, values=player.body.act()[0])
            messages += [
                ("/keeper_1/percept", n / 10, seen),
                ("/world/actions", n / 10 + 0.01, act),
            ]
    write(path, *messages)
    return did


@pytest.fixture(scope="module")
def program_driven(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    path = tmp_path_factory.mktemp("bag") / "program.mcap"
    return path, driven(path, 6, 100)


def strip_of(path: Path, *behaviors: str, features: tuple[str, ...] = FEATURES) -> Strip:
    there = driving_of(path, ONE)
    return Strip(there.moments, DOMAIN, there.agent, behaviors, features)


def test_what_a_keeper_does_becomes_a_behavior_that_it_performs(
    keepers: RunningSwarm, hitab: Callable[..., Any], tmp_path: Path
) -> None:
    agents, world = keepers.agents, keepers.world
    recorder = Recorder(keepers.link, tmp_path / "session.mcap")

    def heard() -> bool:
        recorder.look()
        return f"/{ONE}" in recorder.perceiving and not recorder.awaited

    assert keepers.link.spin_until(heard, SECONDS)
    agents.do(ONE, Perform("ServoBall"))
    places = {ONE: {"x": -6.0, "y": 1.0, "heading": 180.0}, "ball": {"x": 0.0, "y": 0.0}}
    world.shown(world.place({**places, "taker_1": {"x": 9.0}, "taker_2": {"x": 8.0}}))
    before = recorder.bag.count
    world.step(60)  # of three keepers, each with a percept and an action
    assert keepers.link.spin_until(lambda: recorder.bag.count > before + 6 * 60, SECONDS)
    keepers.link.spin(0.5)
    recorder.close()
    agents.do(ONE, Perform())

    library = tmp_path / "library"
    words = [str(recorder.bag.path), "Copied", "-a", ONE, "-l", str(library), "--json", "-"]
    shown = hitab("library", "label", *words, *(f"-f{f}" for f in FEATURES))
    assert shown.returncode == 0, shown.stderr
    spans = [span["behavior"] for span in json.loads(shown.stdout)]
    assert spans[:2] == ["TurnToBall", "GoFast"]
    assert "Stop" in spans
    assert "0 moments unexplained" in shown.stderr
    agents.do(ONE, LoadLibrary(str(library)))
    agents.do(ONE, Perform("Copied"))
    assert agents.statuses[ONE].behavior == "Copied"


def test_a_program_is_labeled_moment_by_moment_and_copied(
    program_driven: tuple[Path, list[str]], tmp_path: Path
) -> None:
    path, did = program_driven
    strip = strip_of(path)
    assert [strip.behaviors[i] for i in strip.labels] == did
    assert not strip.unexplained.any()
    library = BehaviorLibrary(tmp_path / "library", DOMAIN)
    saved = strip.train("Copied", library, path.name)
    episodes = groupby(zip((m.episode for m in strip.moments), did, strict=True))
    commands = sum(1 for _ in episodes)
    assert commands == len(strip.spans)
    assert len(saved.automaton.examples) == 2 * commands  # each with its default example
    text = yaml.safe_load(saved.path.read_text(encoding="utf-8"))
    assert "labeled from program.mcap" in text["provenance"]["note"]
    world = KeepawayWorld(replace(PAPER, taker_speed=0.25), 99)
    player = perform(world, Repertoire(DOMAIN, library.load()), "Copied")[ONE]
    world.reset(0)
    player.begin(99, 0)
    agreed = []
    twin = DOMAIN.body(ONE)
    while not world.ended and world.episode_cycle < 60:
        twin.sense(*world.percept(ONE))
        program(twin)
        cycle(world, {ONE: player})
        agreed.append(list(player.body.act()[0]) == list(twin.act()[0]))
    assert sum(agreed) > 0.85 * len(agreed)


def test_a_correction_counts_and_what_lies_around_is_labeled_again(
    program_driven: tuple[Path, list[str]],
) -> None:
    strip = strip_of(program_driven[0], *STATES)
    span = next(s for s in strip.spans if s.behavior == "GoMedium")
    strip.correct(span.begin, span.end, "GoSlow")
    strip.label()
    again = next(s for s in strip.spans if s.begin <= span.begin < s.end)
    assert again.behavior == "GoSlow"
    assert again.corrected
    with pytest.raises(
        TrainingError, match=r"no moment from 900 to 901 s; they are from 0\.00 to"
    ):
        strip.correct(900, 901, "GoSlow")
    with pytest.raises(VocabularyError, match='unknown behavior "Pass"'):
        strip.correct(span.begin, span.end, "Pass")


def test_what_no_behavior_explains_is_visible_and_all_of_it_is_refused(
    program_driven: tuple[Path, list[str]],
) -> None:
    path, did = program_driven
    strip = strip_of(path, *(set(STATES) - {"GoFast"}))
    assert strip.unexplained.tolist() == [name == "GoFast" for name in did]
    assert sum(span.unexplained for span in strip.spans) == did.count("GoFast")
    with pytest.raises(TrainingError, match=r"do not explain what keeper_1 did at .* moments"):
        strip_of(path, "GoSlow", "TurnToBall", "GoMedium")


@pytest.mark.parametrize(
    ("behaviors", "features", "problem"),
    [
        (("GoFast", "Sotp"), FEATURES, 'Did you mean "Stop"?'),
        (("GoFast",), FEATURES, "choose at least two basic behaviors"),
        (("GoFast", "TurnTo"), FEATURES, "takes 1 target"),
        ((), ("DistanceTo(bal)",), 'Did you mean "ball"?'),
        ((), ("SecondsInState",), "choose other features"),
    ],
)
def test_unknown_words_are_refused(
    program_driven: tuple[Path, list[str]], behaviors: Any, features: Any, problem: str
) -> None:
    with pytest.raises(VocabularyError) as refused:
        strip_of(program_driven[0], *behaviors, features=features)
    assert problem in str(refused.value)


def test_three_moments_can_be_labeled(tmp_path: Path) -> None:
    did = driven(tmp_path / "short.mcap", 1, 3)
    assert len(strip_of(tmp_path / "short.mcap", *STATES).labels) == len(did) == 3


def test_a_recording_without_the_agent_or_without_actions_is_refused(
    program_driven: tuple[Path, list[str]], tmp_path: Path
) -> None:
    with pytest.raises(SwarmError, match=r'nothing of an agent "keeper_7".*known: /keeper_1'):
        driving_of(program_driven[0], "keeper_7")
    only = write(tmp_path / "only.mcap", ("/keeper_1/percept", 0.0, Percept(sequence=1)))
    with pytest.raises(SwarmError, match="1 percept of keeper_1, but not what was done: it lacks"):
        driving_of(only)
    none = write(tmp_path / "none.mcap", ("/world/status", 0.0, WorldStatus()))
    with pytest.raises(SwarmError, match="no percepts of any agent"):
        driving_of(none)
    look = Percept(sequence=1, look=True)
    paused = write(tmp_path / "paused.mcap", ("/keeper_1/perceived", 0.0, look))
    with pytest.raises(SwarmError, match="the world was paused while it was recorded"):
        driving_of(paused)


def test_a_robot_did_what_it_was_driven_with(tmp_path: Path) -> None:
    turn = Twist(linear=Vector3(x=0.2), angular=Vector3(z=1.0))
    path = write(
        tmp_path / "robot.mcap",
        *[("/robot_1/perceived", float(i), Percept(sequence=i + 1)) for i in range(4)],
        ("/robot_1/cmd_vel", 1.5, turn),
        ("/robot_1/cmd_vel", 3.5, Twist()),
    )
    did = [moment.did for moment in driving_of(path).moments]
    assert did == [None, (0.2, 0.0, 1.0), (0.2, 0.0, 1.0), (0.0, 0.0, 0.0)]


def test_the_command_corrects_and_refuses(
    program_driven: tuple[Path, list[str]], hitab: Callable[..., Any], tmp_path: Path
) -> None:
    words = ["library", "label", str(program_driven[0]), "Copied", *(f"-f{f}" for f in FEATURES)]
    wrong = hitab(*words, "--was", "soon=Stop")
    assert wrong.returncode == 2
    assert '"soon=Stop" is not FROM-TO=BEHAVIOR' in wrong.stderr
    late = hitab(*words, "--was", "900-901=Stop", "-l", str(tmp_path / "library"))
    assert late.returncode == 1
    assert "no moment from 900 to 901 s" in late.stderr
    assert not (tmp_path / "library").exists()
    shown = hitab(*words, "--was", "0-0.5=Stop")
    assert "corrected" in shown.stdout
