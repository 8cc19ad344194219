"""Simulated people train keepers; the benchmark counts how many get what they intended."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from hitab_core import Repertoire
from hitab_world import Placement
from hitab_world.inprocess import perform, play
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))
import teachers
from agreement import objections
from habits import Diary, Habits
from intentions import INTENTIONS, KICKABLE, Intention, Plan
from practice import approaching
from pupils import InProcessPupil
from simulated_people import Course, Person
from teachers import NOTHING
from trial import Memory, Trial

LESSONS = INTENTIONS["lessons"]
APPROACH = LESSONS.plans[0]


@pytest.fixture
def pupil():
    pupil = InProcessPupil(seed=3)
    yield pupil
    pupil.close()


def trained(habits, pupil, seed=1, **options):
    """Return the examples of a person who trains ApproachBall alone."""
    person = Person(Intention("one", "", (APPROACH,)), habits, seed, **options)
    course = Course(person, pupil, APPROACH, person.budget)
    pupil.begin(APPROACH)
    course.practise(approaching, guided=2)
    assert course.save()
    return pupil.repertoire.automata["ApproachBall"].examples


@pytest.mark.parametrize("name", INTENTIONS)
def test_an_intention_plays_itself(name):
    intention = INTENTIONS[name]
    world = KeepawayWorld(seed=4)
    repertoire = Repertoire(DOMAIN, intention.automata())
    results = play(world, perform(world, repertoire, intention.plans[-1].name), 2)
    assert all(result.seconds > 4.0 for result in results)


def test_what_plays_itself_is_not_objected_to():
    values = {("GoFast", "GoMedium"): [(4.9,)], ("GoFast", "GoFast"): [(9.0,)]}
    found = objections(APPROACH, APPROACH.automaton(), values)
    assert found == {"GoFast -> GoMedium": 0.0, "GoFast stays": 0.0}


def test_a_perfect_person_places_thresholds_where_they_were_intended(pupil):
    commands = {
        (e.state, e.next_state): e.features[0] for e in trained(NOTHING, pupil) if not e.is_default
    }
    assert 3.9 <= commands["GoFast", "GoMedium"] <= 5.0  # it runs 1 m in a cycle
    assert 1.5 <= commands["GoMedium", "GoSlow"] <= 2.5


def test_a_late_person_commands_late_unless_the_reaction_time_is_applied():
    def threshold(**options):
        pupil = InProcessPupil(seed=3)
        examples = trained(replace(NOTHING, reaction=(0.3, 0.3)), pupil, **options)
        pupil.close()
        return next(e.features[0] for e in examples if e.next_state == "GoMedium")

    assert threshold() < 3.5
    assert 3.9 <= threshold(says_ago=True) <= 6.0  # a cycle early or late


def test_nobody_records_more_than_the_budget(pupil):
    hurried = Habits(wrong=0.3)
    examples = trained(hurried, pupil, budget=12)
    assert 2 <= len(examples) <= pupil.given <= 12


def test_the_same_person_teaches_the_same():
    taught = []
    for _ in range(2):
        pupil = InProcessPupil(seed=3)
        taught.append([(e.state, e.features, e.next_state) for e in trained(Habits(), pupil)])
        pupil.close()
    assert taught[0] == taught[1]


def test_a_wrong_command_is_noticed_and_taken_back(pupil):
    habits, diary, memory = replace(NOTHING, wrong=1.0, repairs=1.0), Diary(), Memory()
    person = Person(LESSONS, habits, 1)
    pupil.begin(APPROACH)
    Trial(pupil, APPROACH, habits, person.random, diary, memory, 60, 0.0).play(
        approaching(person.random, 0), guided=True
    )
    assert diary.counts["wrong"] == diary.counts["taken back"] > 0
    assert not memory.shown


def test_a_command_was_due_when_what_it_responds_to_came_about():
    def recorded(events):
        plan = Plan("Face", ("TurnToBall", "Stop"), (KICKABLE,), LESSONS.plans[2].rule, {})
        pupil = InProcessPupil(seed=3, events=events)
        pupil.begin(plan)
        keeper, ball = Placement("keeper_1", 0.0, 0.0), Placement("ball", -4.0, 0.0, 0.0, 8.0, 0.0)
        pupil.place([keeper, ball])
        pupil.command("TurnToBall")
        while not pupil.step().values[KICKABLE]:
            pass
        for _ in range(3):
            pupil.step()
        taught = pupil.command("Stop", ago=0.4)  # 0.3 s would be right
        pupil.close()
        return taught[0].features

    assert recorded(events=False) == (0.0,)
    assert recorded(events=True) == (1.0,)


def test_unknown_aids_are_refused():
    app = typer.Typer()
    app.command()(teachers.main)
    result = CliRunner().invoke(app, ["--people", "1", "--without", "luck"])
    assert result.exit_code == 2
    assert 'no aid "luck"' in result.output


def test_the_benchmark_prints_and_writes_its_figures(tmp_path):
    app = typer.Typer()
    app.command()(teachers.main)
    path = tmp_path / "figures.json"
    arguments = ["--people", "1", "--episodes", "2", "--diagnose", "--json", str(path)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "as asked" in result.output
    person = json.loads(path.read_text())["people"]["as asked"][0]
    assert person["intention"] == "lessons"
    assert person["given"] <= 60
    assert person["objections"]
