"""Simulated people train keepers; the benchmark counts how many get what they intended."""

import json
import math
from dataclasses import replace
from random import Random

import pytest
import teachers
import typer
from agreement import objections
from habits import Diary, Habits
from intentions import INTENTIONS, KICKABLE, OFF, Intention, Plan
from peers import OPTIONS
from peers_of_people import commands_of
from people_tables import interval
from practice import approaching
from pupils import InProcessPupil
from second_thoughts import SecondThoughts, as_seen
from simulated_people import MENDING, Course, Person
from tasks import uses
from teachers import NOTHING, Setting, intention_of, person_of, pupil_of
from topic_pupil import TopicPupil
from trial import Memory, Trial, begins
from typer.testing import CliRunner

from hitab_core import Automaton, Example, ExampleKind, HandWritten, Repertoire
from hitab_core.training.question import KEEP, REMOVE, Choice, Question, QuestionKind
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
    assert 3.9 <= threshold(says_ago=True) <= 5.0


def test_no_training_holds_more_than_the_budget(pupil):
    hurried = Habits(wrong=0.3)
    examples = trained(hurried, pupil, budget=12)
    assert 2 <= len(examples) == pupil.held <= min(12, pupil.given)


def test_what_is_taken_back_is_given_but_not_held(pupil):
    examples = trained(NOTHING, pupil)
    given = pupil.given
    pupil.begin(APPROACH, resume=True)
    pupil.place([])
    pupil.command("GoFast")
    assert pupil.held > len(examples)
    pupil.undo()
    assert pupil.held == len(examples)
    pupil.delete([examples[0].number])
    assert pupil.held == len(examples) - 1
    assert pupil.given > given


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


def test_a_person_keeps_a_command_that_comes_only_a_little_early(pupil):
    assert 5.0 < running(pupil, away=13.0) < 6.0
    taught = pupil.command("GoMedium")
    assert thoughts(pupil).review([taught[0].number]) == []
    (kept,) = [e for e in pupil.examples() if e.number == taught[0].number]
    assert kept == taught[0], "where it was"


def test_a_person_shows_again_what_only_a_deleted_command_had_shown(pupil):
    person = Person(LESSONS, NOTHING, 1)
    running(pupil)
    course = Course(person, pupil, APPROACH, 60)
    (begin, _) = pupil.examples()
    kind = course._trial().kind("Start", "GoFast", {})
    course.memory.shown.add(kind)
    course._forget(course._trial(), [replace(begin, number=9)])
    assert course.memory.shown == {kind}, "another example shows it"
    pupil.delete([begin.number])
    course._forget(course._trial(), [begin])
    assert course.memory.shown == set()
    assert course.memory.lost == {kind}


def test_a_person_shows_again_what_to_begin_with_before_saving(pupil):
    running(pupil)
    course = Course(Person(LESSONS, NOTHING, 1), pupil, APPROACH, 60)
    (begin, _) = pupil.examples()
    pupil.delete([begin.number])
    assert not begins(pupil)
    assert course.save()


def test_people_see_directions_to_the_right_as_negative():
    assert as_seen(LESSONS.plans[1], (6.2,)) == {OFF: pytest.approx(6.2 - math.tau)}
    assert as_seen(APPROACH, (6.2,)) == {"DistanceTo(ball)": 6.2}


def test_a_person_deletes_a_default_example_of_a_state_that_would_be_left(pupil):
    assert 1.05 < running(pupil, away=8.5) < 2.5  # near enough to go slowly
    taught = pupil.command("GoMedium")
    thoughts(pupil)._check_default(taught[0].command)
    kinds = [e.kind.value for e in pupil.examples() if e.command == taught[0].command]
    assert kinds == ["demonstrated"]


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


@pytest.mark.parametrize(
    ("command", "unlearns", "answer"),
    [("Stop", True, "remove"), ("GoMedium", True, "keep"), ("Stop", False, "")],
)
def test_a_person_says_whether_an_example_was_a_mistake(pupil, command, unlearns, answer):
    assert 2.5 < running(pupil) < 4.0
    taught = pupil.command(command)
    numbers = tuple(e.number for e in taught)
    choices = tuple(Choice(name, "", None) for name in (REMOVE, KEEP))
    question = Question(1, QuestionKind.MISTAKE, "?", taught[0].state, numbers, choices)
    answers = []
    pupil.answer = lambda number, choice: answers.append(choice)
    second = thoughts(pupil)
    second.unlearns = unlearns
    second._answer(question)
    assert answers == [answer]


def test_a_person_shows_again_what_an_answer_deleted(pupil):
    running(pupil)
    course = Course(Person(LESSONS, NOTHING, 1, answers=True), pupil, APPROACH, 60)
    pupil.command("Stop")
    pupil.place([Placement("keeper_1", -9.0, 0.0, 0.0), Placement("ball", 1.0, 0.0)])
    trial = course._trial()
    course.memory.shown = {trial.kind("Start", to, {}) for to in ("GoFast", "GoSlow")}
    pupil.command("GoSlow")
    trial.settle(trial)
    assert pupil.contradictions() == 0
    assert course.memory.lost == {trial.kind("Start", "GoSlow", {})}


def test_a_person_sees_which_plan_below_does_the_wrong_thing(pupil):
    far = [Placement("keeper_1", -9.0, 0.0, 0.0), Placement("ball", 1.0, 0.0)]
    pupil.begin(APPROACH)
    pupil.place(far)
    pupil.command("Stop")  # instead of GoFast
    pupil.save(keep_unused=True)
    go_to = LESSONS.plans[1]
    pupil.begin(go_to)
    course = Course(Person(LESSONS, Habits(), 1), pupil, go_to, 60)
    trial = course._trial()
    pupil.place(far)
    pupil.command("ApproachBall")
    seen = []
    for trial.now in range(1, 8):
        trial.look_below(pupil.step())
        seen.append("ApproachBall" in trial.troubled)
    assert not seen[1], "not at once"
    assert trial.troubled == {"ApproachBall"}


def test_a_person_goes_back_to_the_plan_that_hinders_the_next_one(pupil):
    person = Person(LESSONS, Habits(), 1)
    resumed = []
    person._resume = lambda pupil, course: resumed.append((course.plan.name, course.allowance))
    lower, course = (Course(person, pupil, plan, 20) for plan in LESSONS.plans[:2])
    trained(NOTHING, pupil)
    most = pupil.held + MENDING
    course.troubles["ApproachBall"] = 1
    person._mend_below(pupil, course, [lower])
    assert resumed == [], "once can happen"
    course.troubles["ApproachBall"] = 2
    person._mend_below(pupil, course, [lower])
    assert resumed == [("ApproachBall", most), ("GotoBall", most)]
    resumed.clear()
    person.diary.content.append("GotoBall")
    person._mend_below(pupil, course, [lower])
    assert resumed == []


def test_a_person_lets_the_world_run_slower_where_a_command_came_after_the_end(pupil):
    person = Person(LESSONS, replace(NOTHING, reaction=(0.4, 0.4)), 1, slows=True)
    memory = Memory(pace=0.5)
    pupil.begin(APPROACH)
    trial = Trial(
        pupil, APPROACH, person.habits, person.random, Diary(), memory, 60, 0.4, slows=True
    )
    assert trial.cycles(person.habits.reaction) == 2
    trial.play(approaching(person.random, 0), guided=True)
    late = [e.ago for e in pupil.examples() if e.ago > 0.0]
    assert late
    assert max(late) == pytest.approx(0.2)


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
    arguments = ["--people", "1", "--episodes", "2", "--own-episodes", "2", "--diagnose"]
    arguments += ["--peers", "--json", str(path)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "as asked" in result.output
    person = json.loads(path.read_text())["people"]["as asked"][0]
    assert person["intention"] == "lessons"
    assert person["held"] <= min(60, person["given"])
    assert person["objections"]
    assert person["peers"].keys() == OPTIONS.keys()
    assert "as asked, nearest neighbors" in result.output


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


def test_other_learners_get_the_commands_as_commands_of_basic_behaviors(pupil):
    trained(NOTHING, pupil)
    learned = dict(pupil.repertoire.automata)
    flat = commands_of(learned)
    given = [e for e in learned["ApproachBall"].examples if not e.is_default]
    assert [c.behavior for c in flat] == [e.next_state for e in given]
    assert [c.readings[0] for c in flat] == [e.features[0] for e in given]
    assert flat[0].state == "Start"

    # The same commands, one level up: GotoBall begins with TurnToBall or ApproachBall.
    go_to = Automaton(
        "GotoBall",
        uses("TurnToBall ApproachBall"),
        uses("DirectionTo(ball)"),
        {"Start": HandWritten(lambda off: "ApproachBall" if off < 0.1 else "TurnToBall", (0,))},
        examples=(
            Example("Start", (0.0,), "ApproachBall"),
            Example("ApproachBall", (0.5,), "TurnToBall"),
            Example("TurnToBall", (0.5,), "TurnToBall", ExampleKind.DEFAULT),
            Example("TurnToBall", (0.5,), "Done"),
        ),
    )
    approach, turn = commands_of(learned | {"GotoBall": go_to})[len(flat) :]
    begins = {e.next_state for e in given if e.state == "Start"}
    assert approach.behavior in begins
    assert (turn.state, turn.behavior) == (approach.behavior, "TurnToBall")


def test_each_aid_is_switched_off_by_itself():
    given = teachers.Setting(Habits())
    made = teachers.cases(given, {"all": Habits(wrong=0.1)}, each_aid=True)
    off = {title: given.aids - case.aids for title, case in made.items()}
    assert off == {
        "all": set(),
        **{f"all, without {aid}": {aid} for aid in teachers.AIDS},
        "all, without any aid": given.aids,
    }
    assert {case.habits.wrong for case in made.values()} == {0.1}


def test_the_interval_of_a_count_is_wilsons():
    assert interval(13, 20) == pytest.approx((0.433, 0.819), abs=5e-4)
    assert interval(0, 10) == pytest.approx((0.0, 0.278), abs=5e-4)
    assert interval(10, 10) == pytest.approx((0.722, 1.0), abs=5e-4)


@pytest.mark.parametrize(("sides", "state"), [(True, "TurnToBall"), (False, "Stop")])
def test_one_command_among_default_ones_shows_a_side_of_the_circle_with_the_aid(sides, state):
    pupil = InProcessPupil(seed=3, sides=sides)
    pupil.begin(Plan("Face", ("TurnToBall", "Stop"), (OFF,), LESSONS.plans[1].rule, {}))
    for ball, command in (((5.0, 0.0), "Stop"), ((5.0, 2.0), "TurnToBall")):
        pupil.place(
            [Placement("keeper_1", 0.0, 0.0, 0.0), Placement("ball", *ball)],
            new_episode=command == "Stop",
        )
        pupil.command(command)
    pupil.save()
    learned = pupil.repertoire.automata["Face"].transitions["Stop"]
    pupil.close()
    assert list(learned.predict([[1.0]])) == [state]
