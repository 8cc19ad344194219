"""Whatever changes what an agent can do: disk, memory and the answer say the same afterwards."""

import itertools
import os

import pytest
from bodies import Body, pulsed
from faulty_disk import FaultyDisk, Killed, use_statements

from hitab_core.agent import Agent
from hitab_core.domain import BasicBehavior, Domain, Feature, Target
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.bundle import digest_in, make_bundle, plan_bundle
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.texts.errors import HitabError, LibraryError, VocabularyError
from hitab_core.training import Curriculum
from hitab_core.training.training_journal import TrainingJournal


@pytest.fixture(scope="module")
def line():
    return Domain.of(
        "line", "1", Body,
        behaviors=[
            *pulsed("Left", "Right"),
            BasicBehavior("Near", lambda body, target: None, parameters=("A",)),
        ],
        features=[Feature("x", lambda body: body.x, unit="m")],
        targets=[Target("ball", lambda body: "ball")],
    )  # fmt: skip


@pytest.fixture
def make(tmp_path, line):
    def make(name="ann", library=None):
        return Agent(
            name, line, library or BehaviorLibrary(tmp_path / name / "library", line),
            tmp_path / name,
        )  # fmt: skip

    return make


def teach(agent, name, *states, parameters=(), save=True):
    """Train an automaton that begins with the first and ends with the last of these states."""
    arguments = ("ball",) * len(parameters)
    agent.begin(Curriculum(name, (Term("x"),), (), parameters, arguments), discard=True)
    for x, state in enumerate(states):
        agent.sense([float(x)], [])
        agent.command(Term.parse(state))
    return agent.save() if save else None


def known(agent):
    """What an agent can do and is being taught, as far as it survives."""
    session = agent.session
    return (
        agent.loaded.digest,
        {n: f.text for n, f in agent.loaded.files.items()},
        sorted(agent.repertoire.automata),
        session and (session.curriculum, session.examples),
    )


def _save(agent, make):
    return agent.save


def _save_over_what_is_performed(agent, make):
    teach(agent, "Go", "Near(A)", parameters=("A",))
    teach(agent, "Go", "Left", save=False)
    agent.perform(Term("Go", ("ball",)))
    return agent.save


def _reload(agent, make):
    other = make("other", BehaviorLibrary(agent.library.folder, agent.domain))
    teach(other, "More", "Right")
    return agent.reload


CHANGES = (_save, _save_over_what_is_performed, _reload)


@pytest.mark.parametrize("how", ["once", "full", "killed"])
@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__.strip("_"))
def test_disk_memory_and_answer_agree_whichever_operation_fails(
    make, change, how, monkeypatch, tmp_path
):
    monkeypatch.setattr(os, "fsync", lambda descriptor: None)  # there is no power failure here
    use_statements(monkeypatch)
    for number in itertools.count(1):
        folder = f"round_{number}"

        def make_one(name, library=None, folder=folder):
            return make(f"{folder}/{name}", library)

        agent = make_one("ann")
        teach(agent, "Home", "Left", "Right")
        teach(agent, "Away", "Right", save=False)
        act = change(agent, make_one)
        before = known(agent)
        with monkeypatch.context() as patch:
            disk = FaultyDisk(patch, tmp_path, number, how)
            answer, why = "done", str(tmp_path)
            try:
                act()
            except HitabError as error:
                answer, why = "refused", str(error)
            except Killed:
                answer = "killed"
        assert str(tmp_path) in why, "it names the place"
        after = known(agent)
        if answer == "refused":
            assert after == before
        if answer == "done":
            assert after[:3] != before[:3]
        agent.journal.close()  # as the end of the process does
        again = make_one("ann")
        if answer == "killed":
            now = known(again)
            made = now[:3] != before[:3]
            if made and change not in (_save, _save_over_what_is_performed):
                assert {"Low", "High"} <= {*now[1]} or "More" in now[1]
            # A training is either saved or offered again, and no other change touches it.
            saved = made and change in (_save, _save_over_what_is_performed)
            assert now[3] == (None if saved else before[3])
        elif change is _reload:
            assert "More" in again.repertoire
        else:
            assert known(again) == after, f"operation {number}, {answer}"
        for file in again.loaded.files.values():
            again.perform(Term(file.name, ("ball",) * len(file.automaton.parameters)))
        if not disk.failed:
            assert answer == "done"
            break
    assert number > 1


def test_the_training_that_was_saved_is_not_offered_again_if_the_journal_could_not_be_put_away(
    make, monkeypatch
):
    agent = make()
    teach(agent, "Home", "Left", "Right", save=False)
    with monkeypatch.context() as patch:

        def killed(journal):
            raise Killed

        patch.setattr(TrainingJournal, "archive", killed)
        with pytest.raises(Killed):
            agent.save()
    agent.journal.close()
    again = make()
    assert again.session is None
    assert again.mode is Mode.IDLE
    assert "Home" in again.repertoire
    teach(again, "Away", "Left", save=False)
    again.journal.close()
    assert make().session.curriculum.name == "Away"


def test_the_training_is_offered_again_if_it_was_about_to_be_saved_and_was_not(make, monkeypatch):
    agent = make()
    teach(agent, "Home", "Left", "Right", save=False)
    expected = agent.session.examples
    with monkeypatch.context() as patch:

        def killed(folder, changes):
            raise Killed

        patch.setattr("hitab_core.library.change.commit", killed)
        with pytest.raises(Killed):
            agent.save()
    agent.journal.close()
    again = make()
    assert again.session.examples == expected
    again.save()
    assert "Home" in make().repertoire


def test_saving_over_what_is_performed_saves_and_leaves_the_agent_idle_and_says_so(make):
    agent = make()
    teach(agent, "Go", "Near(A)", parameters=("A",))
    teach(agent, "Go", "Left", save=False)
    agent.perform(Term("Go", ("ball",)))
    _, path, notes, _ = agent.save()
    assert path.exists()
    assert any('ann is idle now; it cannot perform "Go(ball)"' in note for note in notes)
    assert (agent.mode, agent.session) == (Mode.IDLE, None)
    agent.tick()
    agent.perform(Term("Go"))
    make().perform(Term("Go"))


def test_what_others_use_is_not_saved_with_other_parameters_and_nothing_is_lost(make):
    agent = make()
    teach(agent, "Low", "Near(A)", parameters=("A",))
    teach(agent, "High", "Low(ball)")
    before = agent.library.texts()
    teach(agent, "Low", "Left", save=False)
    with pytest.raises(HitabError, match=r'"High"|High\.hfa\.yaml'):
        agent.save()
    assert agent.session is not None
    assert BehaviorLibrary(agent.library.folder, agent.domain).loaded().texts == before
    agent.save("Lower")
    assert "Lower" in make().repertoire


def test_a_bundle_that_does_not_fit_to_what_is_performed_is_refused_before_it_is_written(make):
    pupil, teacher = make("pupil"), make("teacher")
    teach(pupil, "Go", "Near(A)", parameters=("A",))
    pupil.perform(Term("Go", ("ball",)))
    teach(teacher, "Go", "Left")
    bundle = make_bundle(teacher.loaded.texts, teacher.repertoire, "Go")
    before = known(pupil)
    with (
        pupil.library.change() as change,
        pytest.raises(
            VocabularyError, match=r'no longer perform "Go\(ball\)".*something else first'
        ),
    ):
        pupil.check_fit(plan_bundle(change, bundle))
    assert known(pupil) == known(make("pupil")) == before
    assert pupil.behavior == "Go(ball)"
    # The ways out that the error names, and that of starting what has come.
    with pupil.library.change() as change:
        loaded = plan_bundle(change, bundle)
        pupil.check_fit(loaded, Term("Go"))
        change.commit()
    pupil.take_up(loaded, Term("Go"))
    assert digest_in(pupil.loaded, dict(bundle.files)) == bundle.digest
    assert pupil.behavior == "Go"


def test_a_behavior_whose_start_fails_is_saved_and_the_answer_tells_both(make):
    agent = make()
    teach(agent, "Home", "Left", save=False)
    agent.test()
    broken = RuntimeError("the wheel is off")

    def fail():
        raise broken

    agent.session.running.stop = fail
    automaton, _, notes, _ = agent.save()
    assert automaton.name == "Home"
    assert any("the wheel is off" in note for note in notes)
    assert agent.session is None
    assert "Home" in make().repertoire


def test_agents_that_share_a_library_notice_what_one_commits_when_they_reload(
    make, line, tmp_path
):
    shared = BehaviorLibrary(tmp_path / "shared", line)
    elsewhere = BehaviorLibrary(tmp_path / "shared", line)  # as in another process
    ann, bob, cleo = make("ann", shared), make("bob", shared), make("cleo", elsewhere)
    teach(ann, "Low", "Near(A)", parameters=("A",))
    for agent in (ann, bob, cleo):
        agent.reload()
    teach(ann, "High", "Low(ball)")
    bob.perform(Term("Low", ("ball",)))
    ann_knew = ann.loaded
    for agent in (bob, cleo):
        assert "High" not in agent.repertoire
        # It sends the library as loaded, without later changes of the folder by others.
        with pytest.raises(LibraryError):
            make_bundle(agent.loaded.texts, agent.repertoire, "High")
        agent.reload()
        assert agent.loaded.texts == ann_knew.texts
    assert bob.loaded is ann.loaded, "agents of a process share what they have learned"
    assert bob.behavior == "Low(ball)"


def test_a_change_that_one_of_a_shared_library_cannot_follow_leaves_it_what_it_knew(
    make, line, tmp_path
):
    shared = BehaviorLibrary(tmp_path / "shared", line)
    ann, bob = make("ann", shared), make("bob", shared)
    teach(ann, "Go", "Near(A)", parameters=("A",))
    bob.reload()
    bob.perform(Term("Go", ("ball",)))
    before = known(bob)
    teach(ann, "Go", "Left")
    with pytest.raises(VocabularyError, match=r'it keeps its present library.*"Go\(ball\)"'):
        bob.reload()
    assert known(bob) == before
    assert bob.behavior == "Go(ball)"
    bob.tick()
    bob.perform(None)
    bob.reload()
    bob.perform(Term("Go"))
