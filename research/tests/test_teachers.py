"""Simulated people train keepers; the benchmark counts how many get what they intended."""

import json
from dataclasses import replace
from random import Random

import pytest
import teachers
import typer
from habits import Diary, Habits
from intentions import INTENTIONS, Intention
from novices import NOVICE
from people_tables import OFF, by_chance, curve, interval
from practice import approaching
from pupils import InProcessPupil
from second_thoughts import SecondThoughts
from simulated_people import Course, Person
from teachers import NOTHING, Setting, intention_of, person_of, pupil_of
from topic_pupil import TopicPupil
from trial import Memory, Trial
from typer.testing import CliRunner
from ways import GOING_BACK, Ways

from hitab_core import Repertoire
from hitab_world import Placement
from hitab_world.inprocess import perform, play
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld

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


def test_a_perfect_person_places_thresholds_where_they_were_intended(pupil):
    commands = {
        (e.state, e.next_state): e.features[0] for e in trained(NOTHING, pupil) if not e.is_default
    }
    assert 3.9 <= commands["GoFast", "GoMedium"] <= 5.0  # it runs 1 m in a cycle
    assert 1.5 <= commands["GoMedium", "GoSlow"] <= 2.5


def test_a_late_person_commands_late_unless_the_agent_estimates_the_delay():
    def threshold(**options):
        pupil = InProcessPupil(seed=3)
        examples = trained(replace(NOTHING, reaction=(0.3, 0.3)), pupil, **options)
        pupil.close()
        return next(e.features[0] for e in examples if e.next_state == "GoMedium")

    assert threshold() < 3.5
    assert 3.9 <= threshold(estimated=True) <= 6.0  # people are later than this one as a rule


def test_no_training_holds_more_than_the_budget(pupil):
    hurried = Habits(wrong=0.3)
    examples = trained(hurried, pupil, budget=12)
    assert 2 <= len(examples) == pupil.held <= min(12, pupil.given)


def recorded(examples):
    """Return what examples say, in the order of the commands."""
    return [
        (e.command, e.state, e.point, e.next_state, e.kind, e.cycle, round(e.ago, 6))
        for e in examples
    ]


def test_the_same_person_teaches_nodes_over_topics_the_same(home, pupil):
    hurried = Habits(wrong=0.2)
    nodes = TopicPupil(seed=3)
    try:
        assert recorded(trained(hurried, nodes)) == recorded(trained(hurried, pupil))
    finally:
        nodes.close()
    assert (nodes.given, nodes.held) == (pupil.given, pupil.held)


@pytest.mark.long
@pytest.mark.parametrize("number", range(len(INTENTIONS)))
def test_whole_courses_over_topics_teach_the_same(home, number):
    """So that figures of teams in one process hold for nodes, too."""
    given = Setting(Habits(wrong=0.1), seed=11)
    taught = []
    for over_topics in (True, False):
        setting = replace(given, over_topics=over_topics)
        pupil = pupil_of(number, setting)
        try:
            diary = person_of(number, setting).train(pupil)
            automata = pupil.repertoire.automata
        finally:
            pupil.close()
        plans = [plan.name for plan in intention_of(number).plans]
        examples = {name: recorded(automata[name].examples) for name in plans}
        taught.append((examples, diary.figures(), pupil.given, pupil.held))
    assert taught[0] == taught[1]


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
    Trial(pupil, APPROACH, habits, person.random, diary, memory, 60).play(
        approaching(person.random, 0), guided=True
    )
    assert diary.counts["wrong"] == diary.counts["taken back"] > 0
    assert not memory.shown


def thoughts(pupil, habits=None):
    """Return a person's second thoughts about ApproachBall, who overlooks nothing."""
    habits = habits or replace(NOTHING, overlooks=0.0)
    return SecondThoughts(pupil, APPROACH, habits, Random(1), Diary())


def running(pupil, away=10.0):
    """Let the keeper run to a ball that far away, for 8 cycles."""
    pupil.begin(APPROACH)
    pupil.place([Placement("keeper_1", -9.0, 0.0, 0.0), Placement("ball", away - 9.0, 0.0)])
    pupil.command("GoFast")
    for _ in range(8):
        seen = pupil.step()
    return seen.values["DistanceTo(ball)"]


def test_a_person_moves_a_late_command_to_when_it_was_right_first(pupil):
    assert running(pupil) < 4.0
    taught = pupil.command("GoMedium")
    second = thoughts(pupil)
    assert second.review([taught[0].number]) == []
    moved = next(e for e in pupil.examples() if e.number == taught[0].number)
    assert 4.0 <= moved.features[0] <= 5.0
    assert moved.ago > 0.0


def test_a_person_deletes_a_command_that_was_never_right(pupil):
    running(pupil)
    taught = pupil.command("Stop")
    assert [e.number for e in thoughts(pupil).review([taught[0].number])] == [taught[0].number]
    assert len(pupil.examples()) == 2


def test_a_person_says_which_of_two_commands_holds(pupil):
    running(pupil)
    pupil.command("Stop")
    pupil.command("GoMedium")
    assert pupil.contradictions() == 0, "the second one left Stop"
    pupil.place([Placement("keeper_1", -9.0, 0.0, 0.0), Placement("ball", 1.0, 0.0)])
    pupil.command("GoSlow")
    assert pupil.contradictions() == 1
    thoughts(pupil).settle()
    assert pupil.contradictions() == 0
    begin = [e.next_state for e in pupil.examples() if e.state == "Start" and not e.is_default]
    assert begin == ["GoFast"]


def test_a_person_answers_questions_by_the_intention_within_the_budget(pupil):
    trained(NOTHING, pupil)
    pupil.begin(APPROACH, resume=True)
    before, given = len(pupil.examples()), pupil.given
    thoughts(pupil).answer(allowance=pupil.held)
    assert len(pupil.examples()) == before
    thoughts(pupil).answer(allowance=pupil.held + 20)
    added = pupil.examples()[before:]
    assert len(added) == pupil.given - given
    wish = thoughts(pupil).judge()
    for e in added:
        assert e.next_state == wish(e.state, {"DistanceTo(ball)": e.features[0]})


def test_a_person_shows_again_what_an_answer_deleted(pupil):
    running(pupil)
    course = Course(Person(LESSONS, NOTHING, 1, answers=True), pupil, APPROACH, 60)
    pupil.command("Stop")
    pupil.place([Placement("keeper_1", -9.0, 0.0, 0.0), Placement("ball", 1.0, 0.0)])
    trial = course.trial()
    course.memory.shown = {trial.kind("Start", to, {}) for to in ("GoFast", "GoSlow")}
    pupil.command("GoSlow")
    trial.settle(trial)
    assert pupil.contradictions() == 0
    assert course.memory.lost == {trial.kind("Start", "GoSlow", {})}


def test_the_benchmark_prints_and_writes_its_figures(tmp_path):
    app = typer.Typer()
    app.command()(teachers.main)
    path = tmp_path / "figures.json"
    arguments = ["--people", "1", "--episodes", "2", "--own-episodes", "2", "--diagnose"]
    arguments += ["--json", str(path)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "as asked" in result.output
    person = json.loads(path.read_text())["people"]["as asked"][0]
    assert person["intention"] == "lessons"
    assert person["held"] <= min(60, person["given"])
    assert person["objections"]


def test_an_interrupted_benchmark_goes_on_with_what_it_has_finished(tmp_path, monkeypatch):
    app = typer.Typer()
    app.command()(teachers.main)
    kept = tmp_path / "kept.jsonl"
    arguments = ["--episodes", "2", "--own-episodes", "2", "--resume", str(kept), "--people"]
    whole = CliRunner().invoke(app, [*arguments, "2"])
    assert whole.exit_code == 0, whole.output
    lines = kept.read_text().splitlines(keepends=True)
    kept.write_text("".join(lines[:2]) + lines[2][:9])  # killed while it wrote

    trained: list[int] = []
    train_and_play = teachers.train_and_play

    def watched(number, setting):
        trained.append(number)
        return train_and_play(number, setting)

    monkeypatch.setattr(teachers, "train_and_play", watched)
    again = CliRunner().invoke(app, [*arguments, "2"])
    assert trained == [1]
    assert again.output.splitlines()[-1] == whole.output.splitlines()[-1]
    assert kept.read_text() == "".join(lines)

    other = CliRunner().invoke(app, [*arguments, "2", "--seed", "5"])
    assert other.exit_code == 2
    assert "name another file" in " ".join(other.output.split())


def test_the_interval_of_a_count_is_wilsons():
    assert interval(13, 20) == pytest.approx((0.433, 0.819), abs=5e-4)
    assert interval(0, 10) == pytest.approx((0.0, 0.278), abs=5e-4)
    assert interval(10, 10) == pytest.approx((0.722, 1.0), abs=5e-4)


def taught_by(ways):
    """Return the diary of a novice with these ways, and the keeper that it taught."""
    setting = Setting(NOVICE, seed=11, novices=True, ways=ways)
    pupil = pupil_of(1, setting)
    try:
        diary = person_of(1, setting).train(pupil)
    finally:
        pupil.close()
    return diary, pupil


def share_off(diary):
    return sum(abs(seconds) > OFF or other for seconds, other in diary.off) / len(diary.off)


def test_a_person_in_time_is_left_alone():
    diary, pupil = taught_by(Ways(delay=0.0))
    assert pupil.lateness < 0.2
    assert share_off(diary) < 0.2


def test_a_person_who_sees_it_coming_is_not_taken_for_late():
    early, pupil = taught_by(Ways(delay=-0.2))
    assert pupil.lateness < 0.2
    assert all(seconds <= 0.5 for seconds, _ in early.off)


def test_going_back_costs_time_and_mends_moments():
    late, _ = taught_by(Ways(delay=0.9))
    back, _ = taught_by(Ways(delay=0.9, goes_back=1.0))
    assert back.counts["went back"] >= len(back.off) > 0
    assert late.counts["went back"] == 0
    assert back.own_seconds >= GOING_BACK * back.counts["went back"]
    assert share_off(back) < share_off(late)


def test_a_frozen_world_shows_what_was_there_after_the_simple_reaction():
    diary, _ = taught_by(Ways(freezes=1.0))
    # Taking over takes longer: a wrong change is seen a cycle later, staying is waited for.
    assert {round(seconds, 6) for seconds, _ in diary.off} <= {0.3, 0.4, 0.6}


def test_what_comes_slower_takes_longer():
    slow = taught_by(Ways(pace=0.5))[0]
    assert slow.own_seconds > 1.05 * slow.seconds


def test_a_team_as_good_as_the_intention_fails_by_chance_when_games_are_few():
    few, many = (by_chance(30.0, 30.0, 24.0, count, count) for count in (100, 400))
    assert few == pytest.approx(0.059, abs=0.005)
    assert many < 0.002


def test_success_is_told_by_commands_given():
    people = [
        {"counts": {"commands": 12}, "success": False, "hold_s": 10.0, "own_s": 20.0},
        {"counts": {"commands": 31}, "success": True, "hold_s": 20.0, "own_s": 20.0},
    ]
    assert [(step["commands"], step["succeed"]) for step in curve(people)] == [(10, 0), (30, 1)]
