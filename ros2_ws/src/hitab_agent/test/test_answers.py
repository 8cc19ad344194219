"""What the services of an agent answer, without a ROS graph."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hitab_agent.agent_services import AgentServices
from hitab_agent.inspection_services import InspectionServices
from hitab_client.learned import learned_of
from hitab_core import Agent, BehaviorLibrary, TrainingError, Use, plain_domain

CART = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position", "Speed"])


class Offered:
    """The services of one agent, called directly."""

    def __init__(self, folder: Path) -> None:
        self._serve: dict[str, tuple[Any, Callable[[Any, Any], Any]]] = {}
        self.sent: list[Any] = []
        library = BehaviorLibrary(folder / "library", CART)
        self.agent = Agent("ann", CART, library, folder / "journal")
        AgentServices(self, self.agent, BehaviorLibrary, lambda error: None)  # type: ignore[arg-type]
        InspectionServices(self, self.agent)  # type: ignore[arg-type]

    def create_service(self, kind: Any, name: str, serve: Callable[[Any, Any], Any]) -> Any:
        self._serve[name] = kind, serve
        return SimpleNamespace(send_response=lambda response, header: self.sent.append(response))

    def create_timer(self, *_: Any, **__: Any) -> Any:
        return SimpleNamespace(cancel=lambda: None, reset=lambda: None)

    def ask(self, name: str, **fields: Any) -> Any:
        kind, serve = self._serve[name]
        return serve(kind.Request(**fields), kind.Response())

    def begin(self, name: str = "Shuttle", **fields: Any) -> str:
        chosen = {"features": ["Position"], **fields}
        return str(self.ask("begin", automaton=name, **chosen).message)

    def show(self, position: float, behavior: str) -> None:
        cycle = self.agent.cycle + 1
        self.agent.sense([position, 0.0], [], cycle, cycle * 0.1)
        self.agent.command(Use(behavior))
        self.agent.tick()


@pytest.fixture
def ann(tmp_path: Path) -> Offered:
    return Offered(tmp_path)


def taught(ann: Offered) -> Offered:
    ann.begin()
    ann.show(0.0, "Right")
    ann.show(5.0, "Left")
    return ann


def test_training_a_saved_name_says_what_saving_will_replace_and_how_to_go_on(
    ann: Offered,
) -> None:
    assert ann.begin() == 'training "Shuttle"'
    taught(ann)
    ann.ask("save")
    told = ann.begin()
    assert told.startswith('training "Shuttle"; saving it will replace the "Shuttle"')
    assert "which has 4 examples" in told
    assert "`hitab train ann Shuttle --resume`, with other features if -f names them" in told
    assert ann.begin(resume="Shuttle") == 'training "Shuttle" with 4 examples'


def test_training_without_features_says_so_and_they_can_be_chosen_later(ann: Offered) -> None:
    told = ann.begin(features=[])
    assert "no feature is chosen, so it cannot tell situations apart" in told
    assert "`hitab examples features ann -f FEATURE`" in told
    ann.show(0.0, "Right")
    ann.show(5.0, "Left")
    ann.ask("edit_examples", action="features", features=["Position"])
    values = [tuple(e.values) for e in ann.ask("list_examples").examples]
    assert values == [(0.0,), (0.0,), (5.0,), (5.0,)]


def test_performing_during_a_training_keeps_it_and_says_how_to_go_on(ann: Offered) -> None:
    assert ann.ask("perform", behavior="Left").message == "ann performs Left"
    taught(ann)
    for asked in ({"behavior": "Left"}, {"behavior": ""}):
        told = ann.ask("perform", **asked).message
        assert told.startswith(f"ann performs {asked['behavior'] or 'nothing'}; ")
        assert 'the training of "Shuttle" (4 examples) is kept: `hitab train ann`' in told
    assert "is kept" in ann.ask("set_mode", mode="idle").message
    assert ann.ask("set_mode", mode="training").message == 'ann is training "Shuttle"'
    assert len(ann.ask("list_examples").examples) == 4


@pytest.mark.parametrize(
    ("service", "way_out"),
    [
        ("edit_examples", "`hitab train ann NAME`"),
        ("list_questions", "`hitab train ann NAME`"),
        ("list_examples", "`hitab examples list ann NAME`"),
        ("get_report", "`hitab examples list ann NAME --cost`"),
        ("save", "`hitab train ann NAME -f FEATURE`"),
    ],
)
def test_what_needs_a_training_says_how_to_begin_one(
    ann: Offered, service: str, way_out: str
) -> None:
    with pytest.raises(TrainingError, match="ann is not training anything") as refused:
        ann.ask(service)
    assert way_out in str(refused.value)


def test_states_that_were_chosen_are_told_apart_from_those_that_were_commanded(
    ann: Offered,
) -> None:
    taught(ann)
    learned = learned_of(ann.ask("get_behavior"))
    assert (learned.states, learned.chosen) == (("Right", "Left"), ())
    ann.begin(states=["Left", "Done"], discard=True)
    learned = learned_of(ann.ask("get_behavior"))
    assert (learned.states, learned.chosen) == (("Left", "Done"), ("Left", "Done"))
    assert learned_of(ann.ask("get_behavior", with_features=[])).chosen == ("Left", "Done")


def test_examples_are_counted_alike_in_the_list_and_in_the_report(ann: Offered) -> None:
    """A superseded one is listed, is counted in both, and is wasted."""
    ann.begin()
    ann.show(0.0, "Right")
    ann.show(0.0, "Left")  # contradicts the default example of the command before
    listed = ann.ask("list_examples").examples
    assert [e.kind for e in listed].count("superseded") == 1
    (cost,) = ann.ask("get_report").costs
    assert cost.examples == len(listed) == 4
    assert cost.wasted == 1


def test_caution_is_confirmed_with_its_limits(ann: Offered) -> None:
    told = ann.ask("set_caution", when_unsure="halt", support=2.0, distance=3.0).message
    assert told == (
        "ann: when it has fewer than 2 examples, or is farther than 3 from any example: halt"
    )
    assert ann.ask("set_caution", when_unsure="go_on").message == "ann: when it is unsure: go_on"


def test_testing_and_saving_say_which_questions_are_open(ann: Offered) -> None:
    taught(ann)
    assert ann.ask("set_mode", mode="testing").message == 'ann is testing "Shuttle"'
    ann.ask("set_mode", mode="training")
    ann.show(0.0, "Right")
    ann.show(5.0, "Right")  # and before: Left
    open_ones = "1 open question, 1 of contradicting commands, where it decides by chance; "
    assert ann.ask("set_mode", mode="testing").message == (
        f'ann is testing "Shuttle"; it has {open_ones}`hitab questions ann` shows what it asks'
    )
    assert ann.ask("save").message.endswith(
        f"it had {open_ones}to answer, `hitab train ann Shuttle --resume` and "
        "`hitab questions ann`"
    )
    ann.begin(resume="Shuttle")
    assert ann.agent.session is not None
    assert ann.agent.session.asked.known(ann.agent.session.log)
