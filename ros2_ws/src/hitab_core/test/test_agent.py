"""An agent without its robot: modes, persistence and refusals."""

import math
import os
import re
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing, nullcontext
from dataclasses import replace

import pytest
from bodies import Body, pulsed
from faulty_disk import files_end_at

from hitab_core.agent import Agent
from hitab_core.assistant import training_costs
from hitab_core.domain import Domain, Feature
from hitab_core.example import ExampleKind
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, LibraryError, TrainingError, VocabularyError
from hitab_core.texts.remedies import Fix
from hitab_core.training import Curriculum


def domain():
    return Domain.of(
        "line", "1", Body,
        behaviors=pulsed("Left", "Right", "Stay"),
        features=[Feature("x", lambda body: body.x, unit="m")],
    )  # fmt: skip


@pytest.fixture
def make(tmp_path):
    def make(name="ann", **more):
        made = domain()
        library = BehaviorLibrary(tmp_path / name / "library", made)
        return Agent(name, made, library, tmp_path / name, **more)

    return make


HOME = Curriculum("Home", (Term("x"),))


def see(agent, x, cycle=1):
    agent.sense([x], [], cycle)


def do(agent, x):
    see(agent, x)
    agent.tick()
    return agent.body.act()[1]


def teach_home(agent):
    agent.begin(HOME)
    see(agent, 5.0)
    agent.command(Term("Left"))
    see(agent, 0.0)
    agent.command(Term("Stay"))


def test_what_is_taught_is_tested_saved_and_performed(make):
    agent = make()
    teach_home(agent)
    agent.test(restart=True)
    assert [do(agent, x) for x in (9.0, 1.0, 0.0)] == ["Left", "Left", "Stay"]
    automaton, path, _, replaced = agent.save(description="go home")
    assert path.exists()
    assert automaton.description == "go home"
    assert replaced == ""
    assert (agent.mode, agent.behavior, agent.session) == (Mode.PERFORMING, "Home", None)
    assert do(agent, 2.0) == "Left"
    with pytest.raises(TrainingError, match='nothing can be saved: "Home" has been saved already'):
        agent.save()


def test_a_behavior_that_is_trained_on_keeps_its_description_unless_another_is_given(make):
    agent = make()
    teach_home(agent)
    agent.save(description="go home")
    for given, kept in (("", "go home"), ("run home", "run home")):
        agent.begin(Curriculum("Home", ()), resume="Home")
        see(agent, 5.0)
        agent.command(Term("Left"))
        assert agent.save(description=given).automaton.description == kept


def test_commands_out_of_training_mode_are_refused_with_the_way_out(make):
    agent = make()
    with pytest.raises(TrainingError, match="it is not training anything"):
        agent.command(Term("Left"))
    teach_home(agent)
    agent.test()
    with pytest.raises(TrainingError, match='"Home" is being tested'):
        agent.command(Term("Left"))
    agent.perform(Term("Right"))
    with pytest.raises(TrainingError, match="it is performing") as refused:
        agent.command(Term("Left"))
    assert refused.value.remedies == (Fix.RESUME(agent="ann"),)
    assert len(agent.session.examples) == 4


def test_a_discarded_training_is_over_and_its_journal_kept(make, tmp_path):
    agent = make()
    teach_home(agent)
    assert (agent.training, agent.unsaved) == ("Home", 4)
    agent.perform(Term("Right"))
    agent.discard()
    assert (agent.mode, agent.training, agent.unsaved) == (Mode.IDLE, "", 0)
    assert agent.active_path == []
    with pytest.raises(TrainingError, match="it has no training to discard"):
        agent.discard()
    again = make()
    assert (again.mode, again.training) == (Mode.IDLE, "")
    with closing(sqlite3.connect(tmp_path / "ann" / "agent.db")) as tables:
        assert tables.execute("SELECT count(*) FROM record").fetchone() == (4,), "it is kept"
    again.begin(HOME)


def test_only_an_agent_in_training_has_files_open(make, tmp_path):
    agents = [make(f"agent_{number}") for number in range(3)]
    teach_home(agents[0])
    teach_home(agents[1])
    assert open_files(tmp_path) == 4
    agents[0].save()
    agents[1].discard()
    training_costs(make("agent_0").journal)
    assert open_files(tmp_path) == 0


def open_files(folder):
    return sum(os.path.realpath(f).startswith(str(folder)) for f in os.scandir("/proc/self/fd"))


STARTING = """
import pathlib, sys
from hitab_core.training import TrainingJournal
journal = TrainingJournal(pathlib.Path(sys.argv[1]) / "ann", "line")
print(journal.resume(None, None), journal.kept(), journal.to_resume(), "sqlite3" in sys.modules)
"""


def test_an_agent_that_never_trained_needs_no_database(tmp_path):
    output = subprocess.check_output([sys.executable, "-c", STARTING, str(tmp_path)], text=True)
    assert output.split() == ["None", "[]", "[]", "False"]
    assert not any(tmp_path.iterdir())


def test_a_training_survives_the_process_with_everything_that_was_done_to_it(make):
    agent = make()
    teach_home(agent)
    see(agent, -4.0)
    agent.command(Term("Right"))
    agent.session.undo()
    agent.session.relabel([4], Term("Right"))
    agent.session.delete([2])
    expected = agent.session.examples
    agent.journal.close()  # as the end of the process does
    again = make()
    assert again.mode is Mode.TRAINING
    assert again.session.examples == expected
    assert again.session.curriculum == HOME
    see(again, 7.0)
    again.command(Term("Left"))
    assert again.session.examples[-1].number > max(e.number for e in expected)


def test_training_goes_on_from_what_was_saved(make):
    agent = make()
    teach_home(agent)
    agent.save()
    agent.begin(Curriculum("Home", ()), resume="Home")
    assert len(agent.session.examples) == 4
    see(agent, -3.0)
    agent.command(Term("Right"))
    agent.save()
    agent.perform(Term("Home"))
    agent.restart(seed=1, episode=1)
    assert len(agent.repertoire.automata["Home"].examples) == 6


def test_training_goes_on_from_an_earlier_version(make):
    agent = make()
    teach_home(agent)
    agent.save()
    first = agent.library.digest
    agent.begin(Curriculum("Home", ()), resume="Home")
    see(agent, -3.0)
    agent.command(Term("Right"))
    agent.save()
    assert agent.library.digest != first
    with pytest.raises(LibraryError, match=r'no version 3 of "Home" \(known: 1, 2\)'):
        agent.begin(Curriculum("Home", ()), resume="Home@3")
    agent.begin(Curriculum("Home", ()), resume="Home@1")
    assert len(agent.session.examples) == 4
    agent.save()
    assert agent.library.digest == first


def test_training_is_resumed_with_the_features_that_were_trimmed(make):
    agent = make()
    curriculum = replace(HOME, features=(Term("x"), Term("SecondsInState")))
    agent.begin(curriculum)
    see(agent, 5.0)
    agent.command(Term("Left"))
    see(agent, 0.0)
    agent.command(Term("Stay"))
    learned = agent.session.automaton()
    agent.save()
    agent = make()  # from the file
    assert agent.repertoire.automata["Home"].features == HOME.features
    agent.begin(Curriculum("Home", ()), resume="Home")
    again = agent.session.automaton()
    assert again.features == curriculum.features
    assert again.examples == learned.examples
    agent.begin(Curriculum("Home", HOME.features), resume="Home", discard=True)
    assert agent.session.automaton().features == HOME.features


def test_the_same_seed_and_episode_give_the_same_decisions(make):
    agent, other = make("one"), make("two")
    draws = []
    for who, episode in ((agent, 3), (agent, 3), (agent, 4), (other, 3)):
        who.restart(seed=9, episode=episode)
        draws.append([who.context.draw() for _ in range(4)])
    assert draws[0] == draws[1]
    assert draws[0] != draws[2]
    assert draws[0] != draws[3], "each agent has its own"


def test_a_command_that_cannot_be_written_down_changes_nothing(make):
    agent = make()
    teach_home(agent)
    before = (agent.session.examples, agent.active_path)
    with files_end_at(100):
        with pytest.raises(LibraryError, match=r"agent.db: .*check the disk and try again"):
            agent.command(Term("Right"))
        with pytest.raises(LibraryError, match=r"agent.db: .*check the disk and try again"):
            agent.session.undo()
        with pytest.raises(LibraryError, match=r"agent.db: .*check the disk and try again"):
            agent.test(restart=True)
    assert (agent.session.examples, agent.active_path) == before
    assert agent.mode is Mode.TRAINING
    agent.command(Term("Right"))
    expected = agent.session.examples
    agent.journal.close()  # as the end of the process does
    assert make().session.examples == expected


@pytest.fixture
def robot(tmp_path):
    """An agent whose feature is required, and whose behavior Stay stands still."""
    made = domain()
    stay = replace(made.behaviors["Stay"], stands_still=True)
    needed = replace(made.features["x"], required=True)
    made = replace(made, behaviors={**made.behaviors, "Stay": stay}, features={"x": needed})
    return Agent("ann", made, BehaviorLibrary(tmp_path / "library", made), tmp_path)


def test_in_training_an_agent_without_a_required_value_waits_for_the_next_command(robot):
    robot.begin(HOME)
    see(robot, 5.0)
    robot.command(Term("Left"))
    assert do(robot, 5.0) == "Left"
    with pytest.raises(FeatureValueError, match='feature "x" has no value'):
        do(robot, math.nan)
    assert robot.session.note.startswith('stands still until the next command: feature "x" has')
    assert do(robot, 5.0) == ""
    assert robot.command(Term("Left"))[0].state == "Start"
    assert do(robot, 5.0) == "Left"
    assert robot.session.note == ""


@pytest.mark.parametrize(
    ("why", "x", "chosen"),
    [
        ("has no value", math.nan, ()),
        ("is not among the states chosen", 5.0, ("Left", "Right")),
        ("check the disk", 5.0, ()),
    ],
)
def test_what_stands_still_is_obeyed_whatever_keeps_it_from_being_recorded(robot, why, x, chosen):
    robot.begin(Curriculum("Home", (Term("x"),), states=tuple(map(Term, chosen))))
    see(robot, 5.0)
    robot.command(Term("Left"))
    see(robot, x)
    with files_end_at(100) if "disk" in why else nullcontext():
        assert robot.command(Term("Stay")) == []
        assert why in robot.session.note
    assert do(robot, x) == do(robot, math.nan) == "Stay"
    assert len(robot.session.examples) == 2


def test_a_training_that_cannot_be_written_down_leaves_the_earlier_one_safe(make):
    agent = make()
    teach_home(agent)
    disk = r"agent.db: .*check the disk and try again"
    with files_end_at(100), pytest.raises(LibraryError, match=disk):
        agent.begin(Curriculum("Other", (Term("x"),)), discard=True)
    assert agent.behavior == "Home"
    agent.command(Term("Right"))
    expected = agent.session.examples
    agent.journal.close()  # as the end of the process does
    assert make().session.examples == expected


def test_a_training_whose_files_are_removed_is_written_again(make, tmp_path):
    agent = make()
    teach_home(agent)
    shutil.rmtree(tmp_path / "ann")
    agent.command(Term("Right"))
    expected = agent.session.examples
    agent.journal.close()  # as the end of the process does
    again = make()
    assert again.session.examples == expected
    shutil.rmtree(tmp_path / "ann")
    again.save()
    assert make().session is None


def test_an_edit_that_leaves_nothing_to_test_is_refused_while_testing(make):
    agent = make()
    teach_home(agent)
    agent.test(restart=True)
    before = agent.session.examples
    with pytest.raises(TrainingError, match="no example leaves Start; take over first, and"):
        agent.session.delete([e.number for e in before if e.state == "Start"])
    assert agent.session.examples == before
    assert do(agent, 2.0) == "Left"


def test_commands_after_a_test_are_corrections_also_after_a_restart(make):
    agent = make()
    teach_home(agent)
    agent.test()
    agent.journal.close()  # as the end of the process does
    again = make()
    see(again, -3.0)
    assert again.command(Term("Right"))[0].kind is ExampleKind.CORRECTION


def test_an_interrupted_training_that_does_not_fit_is_reported_with_its_file(make, tmp_path):
    agent = make()
    teach_home(agent)
    agent.save()
    agent.begin(Curriculum("Far", (Term("x"),)))
    see(agent, 5.0)
    agent.command(Term("Home"))
    agent.journal.close()  # as the end of the process does
    (tmp_path / "ann" / "library" / "Home.hfa.yaml").unlink()
    again = make()
    (fault,) = again.faults
    assert re.search(r'agent.db: .*"Home".*move this file away', fault)
    assert again.session is None


def test_a_library_without_what_is_being_trained_is_refused_and_changes_nothing(make):
    agent = make()
    teach_home(agent)
    agent.save()
    agent.begin(Curriculum("Far", (Term("x"),)))
    see(agent, 5.0)
    agent.command(Term("Home"))
    with pytest.raises(VocabularyError, match='unknown behavior "Home"'):
        agent.reload(BehaviorLibrary(agent.library.folder.parent / "nothing", agent.domain))
    assert "Home" in agent.repertoire
    assert do(agent, 5.0) == "Left"


WRONG = [
    (Curriculum("A" * 101, (Term("x"),)), "is not a name; use up to 100 letters"),
    (Curriculum("A", (Term("x"),), parameters=("P", "P"), arguments=("x", "x")), "twice"),
    (Curriculum("A", (Term("x"),), classifier="os.system"), '"os.system" is not a classifier'),
    (Curriculum("A", (Term("x"),), classifier="tree("), "does not name a classifier"),
]
