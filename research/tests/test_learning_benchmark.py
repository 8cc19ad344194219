"""The scoreboard: peers learn from the commands of lessons, and all play the same episodes."""

import json
import math
from random import Random

import learning
import numpy as np
import pytest
import typer
from peers import ITERATIONS, OPTIONS, Command, Learner, learn
from sklearn.neighbors import KNeighborsClassifier
from sklearn.neural_network import MLPClassifier
from sklearn.tree import DecisionTreeClassifier
from soccer_tasks import Drill, Keepaway
from takeovers import HOLD_CYCLES, Takeovers
from typer.testing import CliRunner

from hitab_client.runs.shipped import shipped
from hitab_core import START, BehaviorLibrary, FeatureKind, Scale, Term
from hitab_core.learning.feature_encoding import encoding_of

SCALES = [Scale(), Scale(FeatureKind.TOROIDAL, 2 * math.pi), Scale(FeatureKind.BOOLEAN)]
BEHAVIORS = ("GoFast", "GoSlow", "Stop")


def commands(count, seed=3):
    """Return commands from random situations, by three distances."""
    draw = Random(seed)
    return [
        Command(
            (
                draw.uniform(0, 3) + 4 * (number % 3),
                draw.uniform(-math.pi, math.pi),
                float(draw.random() < 0.5),
            ),
            START,
            BEHAVIORS[number % 3],
        )
        for number in range(count)
    ]


def run(*arguments):
    app = typer.Typer()
    app.command()(learning.main)
    return CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.mark.parametrize(
    ("name", "made"),
    [
        ("nearest", lambda **o: KNeighborsClassifier(**o)),
        ("tree", lambda **o: DecisionTreeClassifier(random_state=0, **o)),
        (
            "mlp",
            lambda **o: MLPClassifier(solver="lbfgs", max_iter=ITERATIONS, random_state=0, **o),
        ),
    ],
)
def test_a_clone_decides_as_scikit_learn_does(name, made):
    given, asked = commands(18), commands(200, seed=4)
    X = np.array([command.readings for command in given])
    rows = np.array([command.readings for command in asked])
    encoding = encoding_of(X, SCALES)
    for options in OPTIONS[name]:
        policy = learn(name, given, SCALES, options=options)
        # Classes in the order in which they were first commanded, which decides ties.
        y = [policy.behaviors.index(command.behavior) for command in given]
        reference = made(**options).fit(encoding(X), y)
        expected = [policy.behaviors[i] for i in reference.predict(encoding(rows))]
        assert [policy(row, "Stop") for row in rows] == expected


def test_a_flat_automaton_knows_its_state_and_a_clone_does_not():
    given = [
        Command((9.0,), START, "GoFast"),
        Command((1.0,), "GoFast", "Stop"),
        Command((9.0,), "Stop", "GoFast"),
    ]
    flat = learn("flat", given, [Scale()])
    assert [flat((8.0,), state) for state in ("GoFast", "Stop")] == ["GoFast", "Stop"]
    assert flat.examples == 6
    shot = learn("flat", given, [Scale()], one_shot={"Stop"})
    assert shot.examples == 5
    clone = learn("nearest", given, [Scale()])
    assert [clone((8.0,), state) for state in ("GoFast", "Stop")] == ["GoFast", "GoFast"]


class Walker:
    """Wants to walk when far away and to stand when near, whatever it is."""

    def begin(self, seed, episode):
        pass

    def wants(self, readings):
        return "GoFast" if readings[0] > 5.0 else "Stop"


def test_a_teacher_takes_over_where_the_policy_differs_and_lets_go_again():
    learner = Learner("nearest", {"scales": [Scale()], "options": OPTIONS["nearest"][0]})
    takeovers = Takeovers(learner, BEHAVIORS, budget=2)
    functions = takeovers.pupil("Walk", [Term("Distance")], Walker()).transitions
    choose = functions["Stop"].choose
    assert choose(9.0) == "GoFast"
    assert [given.behavior for given in takeovers.commands] == ["GoFast"]
    assert [choose(1.0) for _ in range(HOLD_CYCLES)] == ["Stop"] * HOLD_CYCLES
    assert len(takeovers.commands) == 1  # it played on by itself meanwhile
    assert choose(1.0) == "Stop"  # the policy knew only GoFast
    assert takeovers.over
    takeovers.begin()
    assert choose(8.0) == "GoFast"
    assert choose(2.0) == "Stop"
    assert choose(5.5) == "GoFast"
    assert choose(4.9) == "Stop"
    assert len(takeovers.commands) == 2


def test_lessons_give_in_one_process_what_is_shipped():
    task = Keepaway()
    shown = BehaviorLibrary(shipped("libraries", "keepaway"), task.domain).load()
    taught = task.trained().robots
    assert {*taught} == {*shown}
    for name, automaton in taught.items():
        assert seen(automaton) == seen(shown[name])
    # Each command that is not a flag, at the level of basic behaviors.
    assert len(task.commands) == task.budget - 1
    assert task.school.commands["GotoBall"][1].behavior == "GoMedium"
    assert task.school.commands["Keepaway"][2].state == "Pass"


def seen(automaton):
    return [(e.state, e.features, e.next_state) for e in automaton.examples]


def test_a_captain_without_memory_cannot_do_the_drill():
    task = Drill()
    policy = learn("tree", task.commands, **task.peer_settings)
    (trained,) = task.play(task.trained(), 1, seed=5)
    (clone,) = task.play(task.with_policy(policy, 3), 1, seed=5)
    assert trained > 5 * clone


def test_a_quick_run_makes_every_row_and_prints_them_again(tmp_path):
    file = tmp_path / "learning.json"
    done = run("--quick", "--task", "drill", "--json", file)
    assert done.exit_code == 0, done.output
    rows = json.loads(file.read_text())["tasks"]["drill"]["rows"]
    assert [row["name"] for row in rows] == [e.name for e in learning.entrants(Drill())]
    assert rows[0]["commands"] == 3
    assert rows[0]["examples"] == 6
    assert rows[1]["commands"] == 0
    again = run("--read", file)
    assert again.exit_code == 0, again.output
    table = [line for line in again.output.splitlines() if line.startswith("| ")]
    assert len(table) == len(rows) + 2
    assert table == [line for line in done.output.splitlines() if line.startswith("| ")]
