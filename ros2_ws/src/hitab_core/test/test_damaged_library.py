"""A library with damaged files: what is sound is used, what is lost stays lost, and is named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from bodies import Body, pulsed

from hitab_core.agent import Agent
from hitab_core.automaton import Automaton
from hitab_core.domain import Domain, Feature
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.bundle import Bundle, make_bundle, plan_bundle
from hitab_core.orders.order import ALL_OTHERS, Order
from hitab_core.orders.subordinate import Subordinate
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.texts.errors import LibraryError, LostBehaviorError, TrainingError, VocabularyError
from hitab_core.texts.remedies import Fix
from hitab_core.training import Curriculum

Make = Callable[..., Agent]


@pytest.fixture
def line() -> Domain:
    """Return a domain in which Low and Patrol are also written by hand; Patrol uses Low."""
    return Domain.of(
        "line",
        "1",
        Body,
        behaviors=pulsed("Left", "Right"),
        features=[Feature("x", lambda body: body.x, unit="m")],
        automata=[
            Automaton("Low", (Term("Left"),), (), {}, description="written by hand"),
            Automaton("Patrol", (Term("Low"),), (), {}, description="written by hand"),
        ],
    )


@pytest.fixture
def make(tmp_path: Path, line: Domain) -> Make:
    def make(name: str = "ann", domain: Domain = line) -> Agent:
        folder = tmp_path / name
        return Agent(name, domain, BehaviorLibrary(folder / "library", domain), folder)

    return make


def teach(agent: Agent, name: str, *states: str, save: bool = True) -> None:
    """Train an automaton that begins with the first and ends with the last of these states."""
    agent.begin(Curriculum(name, (Term("x"),)))
    for x, state in enumerate(states):
        agent.sense([float(x)], [])
        agent.command(Term.parse(state))
    if save:
        agent.save()


def end(agent: Agent) -> None:
    """Let go of what the kernel lets go of when a process ends."""
    agent.journal.close()


@pytest.fixture
def trained(make: Make) -> Agent:
    """Return an agent with four behaviors: High uses Middle, which uses Low; Other uses none."""
    agent = make()
    teach(agent, "Low", "Left", "Right")
    teach(agent, "Middle", "Low", "Left")
    teach(agent, "High", "Middle", "Right")
    teach(agent, "Other", "Right", "Left")
    return agent


def file_of(agent: Agent, name: str) -> Path:
    return agent.library.folder / f"{name}.hfa.yaml"


def damage(agent: Agent, name: str) -> None:
    """Cut a file off in its middle, as a full disk or a careless copy does."""
    path = file_of(agent, name)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


def test_an_agent_starts_with_what_is_sound_and_names_what_is_not(
    trained: Agent, make: Make
) -> None:
    damage(trained, "Low")
    agent = make()
    assert sorted(agent.loaded.files) == ["Other"]
    agent.perform(Term("Other"))
    assert agent.mode is Mode.PERFORMING
    (fault,) = agent.faults
    folder = agent.library.folder
    assert fault.startswith(f"Low is lost: its file in {folder} cannot be used: Low.hfa.yaml:")
    assert fault.endswith("; it is needed for High, Middle, Patrol")
    ways_out = (
        Fix.RESTORE(behavior="Low", version=1, folder=folder),
        Fix.DELETE(behavior="Low", folder=folder),
    )
    assert agent.loaded.losses.remedies["High"] == agent.remedies == ways_out
    with pytest.raises(LostBehaviorError) as refused:
        agent.perform(Term("High"))
    assert refused.value.remedies == ways_out


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("Low", "Low is lost: "),
        ("Middle", "Middle needs Low: "),
        ("High", "High needs Middle, which needs Low: "),
        ("Patrol", "Patrol needs Low: "),
    ],
)
def test_nothing_replaces_a_lost_behavior_and_a_request_for_it_is_refused_with_the_reason(
    trained: Agent, make: Make, name: str, reason: str
) -> None:
    damage(trained, "Low")
    agent = make()
    assert name not in agent.repertoire
    assert name not in agent.repertoire.names()
    with pytest.raises(
        LostBehaviorError, match=f"^{reason}its file in .* cannot be used: Low.hfa.yaml"
    ):
        agent.perform(Term(name))
    assert agent.mode is Mode.IDLE
    teach(agent, "New", "Right", save=False)
    with pytest.raises(LostBehaviorError, match=f"^{reason}"):
        agent.command(Term(name))
    with pytest.raises(LibraryError, match=f"cannot be sent: {reason}"):
        make_bundle(agent.loaded.texts, agent.repertoire, name)


def test_a_basic_behavior_does_not_take_the_name_of_a_trained_one(
    trained: Agent, make: Make, line: Domain
) -> None:
    """The new version of a robot may have one of the same name."""
    newer = Domain.of(
        "line",
        "1",
        Body,
        behaviors=[*line.behaviors.values(), *pulsed("Other")],
        features=line.features.values(),
    )
    agent = make(domain=newer)
    with pytest.raises(LostBehaviorError, match='"Other" is a basic behavior of domain "line"'):
        agent.perform(Term("Other"))


def test_a_trained_behavior_that_uses_a_hand_written_one_made_of_a_lost_one_is_lost(
    trained: Agent, make: Make
) -> None:
    teach(trained, "Round", "Patrol")
    damage(trained, "Low")
    with pytest.raises(
        LostBehaviorError, match=r"^Round needs Patrol, which needs Low: its file "
    ):
        make().perform(Term("Round"))


def test_behaviors_that_use_each_other_are_lost_and_others_are_not(
    trained: Agent, make: Make
) -> None:
    other = make("bob")
    teach(other, "Middle", "Right")
    teach(other, "Low", "Middle")
    file_of(trained, "Low").write_bytes(file_of(other, "Low").read_bytes())
    agent = make()
    assert sorted(agent.loaded.files) == ["Other"]
    with pytest.raises(LostBehaviorError, match="recursive"):
        agent.perform(Term("Low"))


def test_a_file_that_was_edited_is_used_as_it_is(trained: Agent, make: Make) -> None:
    path = file_of(trained, "Low")
    path.write_text(path.read_text().replace('description: ""', 'description: "mine"'))
    agent = make()
    assert agent.faults == ()
    assert agent.repertoire.automata["Low"].description == "mine"
    assert "was edited" in agent.loaded.files["Low"].edits[0]


def test_nothing_is_saved_in_place_of_what_is_lost(trained: Agent, make: Make) -> None:
    damage(trained, "Low")
    agent = make()
    for name in ("Low", "Middle"):
        with pytest.raises(VocabularyError, match=f'"{name}" cannot be trained: it would take'):
            agent.begin(Curriculum(name, (Term("x"),)))
        teach(agent, "New", "Left", save=False)
        before = file_of(agent, name).read_bytes()
        with pytest.raises(LibraryError, match=f'"{name}" cannot be saved: it would take'):
            agent.save(name)
        assert file_of(agent, name).read_bytes() == before
        agent.discard()
    teach(agent, "New", "Left")
    assert sorted(agent.loaded.files) == ["New", "Other"]


def test_a_file_that_is_damaged_while_the_agent_is_up_is_not_replaced_by_what_it_saves(
    trained: Agent,
) -> None:
    teach(trained, "Low", "Right", save=False)
    damage(trained, "Low")
    before = file_of(trained, "Low").read_bytes()
    with pytest.raises(LibraryError, match="it would take the place of a lost behavior"):
        trained.save()
    assert file_of(trained, "Low").read_bytes() == before
    assert trained.session is not None


def test_an_agent_that_is_up_keeps_what_it_has_when_a_reload_would_lose_it(
    trained: Agent,
) -> None:
    trained.perform(Term("Other"))
    damage(trained, "Low")
    with pytest.raises(LibraryError, match="it keeps its present library: Low is lost: "):
        trained.reload()
    assert sorted(trained.loaded.files) == ["High", "Low", "Middle", "Other"]
    assert trained.behavior == "Other"


def test_what_is_restored_comes_back_with_all_that_is_made_of_it(
    trained: Agent, make: Make
) -> None:
    damage(trained, "Low")
    agent = make()
    agent.pending_behavior = Term("High")
    BehaviorLibrary(agent.library.folder, agent.domain).restore("Low", 1)
    assert agent.reload() == ["High", "Low", "Middle", "Other"]
    assert agent.faults == ()
    assert agent.behavior == "High", "it performs its pending behavior"
    assert agent.library.on_disk.versions("Low") == [1, 2, 3], "the damaged file is kept, too"


def test_what_is_given_up_can_be_trained_anew_and_brings_back_what_is_made_of_it(
    trained: Agent, make: Make
) -> None:
    damage(trained, "Low")
    agent = make()
    BehaviorLibrary(agent.library.folder, agent.domain).remove("Low")
    agent.reload()
    assert agent.faults == ()
    assert sorted(agent.loaded.files) == [
        "High",
        "Middle",
        "Other",
    ]  # Low is the hand-written one
    teach(agent, "Low", "Right", "Left")
    assert sorted(agent.loaded.files) == ["High", "Low", "Middle", "Other"]


def bundle_of(agent: Agent, name: str) -> Bundle:
    return make_bundle(agent.loaded.texts, agent.repertoire, name)


def take_in(agent: Agent, bundle: Bundle) -> None:
    """Have an agent receive behaviors."""
    with agent.library.change() as change:
        loaded = plan_bundle(change, bundle)
        change.commit()
    agent.take_up(loaded)


def test_other_behaviors_are_received_and_what_is_lost_stays_lost(
    trained: Agent, make: Make
) -> None:
    bob = make("bob")
    take_in(bob, bundle_of(trained, "High"))
    damage(bob, "Low")
    again = make("bob")
    take_in(again, bundle_of(trained, "Other"))
    assert sorted(again.loaded.files) == ["Other"]
    assert "Low.hfa.yaml" in again.faults[0]


def test_an_agent_that_is_ordered_to_perform_what_is_lost_idles_until_it_is_back(
    trained: Agent, make: Make
) -> None:
    damage(trained, "Low")
    agent = make()
    agent.perform(Term("Other"))
    subordinate = Subordinate(agent)
    subordinate.take(Order(1, 1, "Attack", {ALL_OTHERS: "High"}))
    assert agent.mode is Mode.IDLE
    assert subordinate.waits
    assert subordinate.refusal.startswith('cannot obey the order "Attack": High needs Middle, ')
    BehaviorLibrary(agent.library.folder, agent.domain).restore("Low", 1)
    agent.reload()
    assert subordinate.settle()
    assert agent.behavior == "High"
    assert subordinate.refusal == ""


def test_a_training_that_used_what_is_lost_waits_on_disk_until_it_is_back(
    trained: Agent, make: Make
) -> None:
    teach(trained, "New", "High", save=False)
    assert trained.session is not None
    examples = trained.session.examples
    end(trained)
    damage(trained, "Low")
    agent = make()
    assert agent.session is None
    assert any("the interrupted training cannot be resumed: High needs" in f for f in agent.faults)
    with pytest.raises(TrainingError, match="the interrupted training cannot be resumed"):
        agent.begin(Curriculum("Another", (Term("x"),)))
    BehaviorLibrary(agent.library.folder, agent.domain).restore("Low", 1)
    agent.reload()
    assert agent.faults == ()
    assert agent.session is not None
    assert agent.session.examples == examples


@pytest.mark.parametrize("how", ["begin", "discard"])
@pytest.mark.parametrize("size", [None, 100, 4096, 4097, 8192])
def test_a_damaged_training_is_named_and_can_be_given_up_and_is_kept(
    trained: Agent, make: Make, tmp_path: Path, how: str, size: int | None
) -> None:
    teach(trained, "New", "High", save=False)
    end(trained)
    path = tmp_path / "ann" / "agent.db"
    data = path.read_bytes().replace(b"High", b"Hihg")[:size]
    path.write_bytes(data)
    agent = make()
    (fault,) = agent.faults
    assert ("cannot use it" if size else "record 2 of training 5 was damaged or edited") in fault
    assert "; discard the training, or move this file away to start without it" in fault
    if how == "begin":
        agent.begin(Curriculum("Another", (Term("x"),)), discard=True)
    agent.discard()
    kept = path.with_name("agent.1.db").read_bytes() if size else path.read_bytes()
    assert kept == data if size else b"Hihg" in kept
    assert make().faults == ()


def test_a_database_without_tables_yet_is_no_damage(make: Make, tmp_path: Path) -> None:
    (tmp_path / "ann").mkdir()
    (tmp_path / "ann" / "agent.db").touch()
    assert make().faults == ()


def test_a_journal_of_an_earlier_version_is_refused_and_stays(make: Make, tmp_path: Path) -> None:
    path = tmp_path / "ann" / "training.jsonl"
    path.parent.mkdir()
    path.write_text('{"journal": 2}\n')
    agent = make()
    assert "training.jsonl: was written by an earlier HiTAB" in agent.faults[0]
    with pytest.raises(TrainingError, match="discard the training, or move this file away"):
        teach(agent, "New", "Left")
    agent.discard()
    teach(agent, "New", "Left")
    assert (make().faults, path.exists()) == ((), True)


def test_of_a_library_that_cannot_be_read_nothing_is_guessed_and_nothing_is_overwritten(
    trained: Agent, make: Make
) -> None:
    change = trained.library.folder / ".change"
    change.write_text("not a folder")
    agent = make()
    (fault,) = agent.faults
    assert fault.startswith(f"the library cannot be read: {change}: cannot read it: Not a direc")
    agent.perform(Term("Left"))
    for name, reason in (
        ("Low", "the library cannot be read"),
        ("High", '"High" is unknown, and'),
    ):
        with pytest.raises(LostBehaviorError, match=f"^{reason}"):
            agent.perform(Term(name))
    teach(agent, "New", "Left", save=False)
    with pytest.raises(LibraryError, match="cannot read it: Not a directory"):
        agent.save()
    change.unlink()
    assert agent.reload() == ["High", "Low", "Middle", "Other"]
    assert agent.faults == ()
    agent.save()
    assert sorted(make().loaded.files) == ["High", "Low", "Middle", "New", "Other"]
