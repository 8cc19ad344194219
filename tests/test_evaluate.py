"""Evaluating: a seed gives the same episodes, for one team and another."""

import json
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

from hitab_client.runs.shipped import shipped
from hitab_core import BehaviorLibrary, load_domain
from hitab_core.learning.transition_learning import relearned


def evaluated(hitab, *arguments: str) -> dict:
    done = hitab("evaluate", *arguments, "--json", "-")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_any_world_is_evaluated_without_ros(hitab):
    figures = evaluated(hitab, "keepaway_trained", "-n", "3", "--seed", "1")
    assert set(figures["measures"]) == {"seconds", "passes"}
    foraging = ("foraging", "-n", "2", "--set", "foragers=10", "--longest", "2")
    measures = evaluated(hitab, *foraging)["measures"]
    assert set(measures) == {"boxes", "small", "large", "pullers"}
    assert measures == evaluated(hitab, *foraging)["measures"]
    assert measures["boxes"]["better"] == "more"


def test_a_correction_is_compared_with_what_was_before_on_the_same_episodes(
    hitab, tmp_path, monkeypatch
):
    """The team passes too late; then the keeper is shown to pass when a taker is farther away."""
    monkeypatch.chdir(tmp_path)
    library = BehaviorLibrary("lib", load_domain("keepaway"))
    texts = BehaviorLibrary(shipped("libraries", "keepaway"), library.domain).texts()
    library.install(texts)
    control = library.load()["ControlBall"]
    late = [
        replace(e, next_state="Stop") if e.next_state == "Pass" else e for e in control.examples
    ]
    library.save(relearned(replace(control, examples=tuple(late)), library.domain))
    library.save(control, note="corrected")
    plot = tmp_path / "plot.svg"
    figures = evaluated(
        *(hitab, "keepaway_trained", "-l", "lib", "--against", "ControlBall@2"),
        *("-n", "12", "--seed", "7", "--plot", str(plot)),
    )
    assert figures["measures"]["seconds"]["difference"]["verdict"] == "better"
    assert figures["agents"]["against"]["keeper_1"]["versions"] == {"ControlBall": 2}
    assert plot.stat().st_size > 1000
    same = evaluated(
        hitab, "keepaway_trained", "-l", "lib", "--against", "keepaway", "-n", "2", "--seed", "7"
    )
    assert same["measures"]["passes"]["difference"]["mean"] == 0.0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("keepaway",), "no agent performs anything; name a behavior with -b"),
        (("keepaway_trained", "-b", "Chase"), 'has no behavior "Chase"'),
        (("keepaway_trained", "-l", "keeper_9=keepaway"), 'no agent "keeper_9"'),
        (("keepaway_trained", "-l", "absent"), '"absent" is neither a folder nor a library'),
        (("keepaway_trained", "--against", "Keepaway@7"), "7"),
        (("keepaway_trained", "--set", "takers"), '"takers" is not NAME=VALUE'),
        (("keepaway_trained", "--set", "takers=-1"), "takers is -1; it must"),
        (("keepaway_trained", "--set", "wind=1"), 'no parameter "wind"'),
        (("keepaway_trained", "-l", "foraging"), "foraging"),
        (
            ("keepaway", "-b", "keeper_3=GoFast", "--set", "keepers=2"),
            "the world has none of keeper_3",
        ),
    ],
)
def test_what_cannot_be_evaluated_is_refused_with_what_there_is(hitab, arguments, says):
    done = hitab("evaluate", *arguments)
    assert done.returncode == 1
    assert says in done.stderr
    assert "Traceback" not in done.stderr


def test_ctrl_c_prints_what_was_played(home):
    command = [sys.executable, "-m", "hitab_cli.program", "evaluate", "keepaway_trained"]
    with subprocess.Popen(
        [*command, "-n", "1000"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert "of 1000 episodes" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30.0)
    assert process.returncode == 130
    assert "interrupted; " in err
    assert "seconds, s" in out
