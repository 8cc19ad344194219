"""What the page says explains itself: numbers, counts, who decides, and what was taken out."""

import asyncio
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from hitab_msgs.msg import AgentStatus, EmergencyStop, Question

from hitab_client import Learned
from hitab_core import Example
from hitab_core.example import ExampleKind
from hitab_studio.agent_watch import Watched
from hitab_studio.known import Known
from hitab_studio.learned import Vocabulary
from hitab_studio.session import Session
from hitab_studio.studio import Studio
from hitab_studio.swarm_finder import Target
from hitab_studio.views import render
from hitab_studio.views.numbers import counted, duration, measure

ONE = "keeper_1"


@pytest.mark.parametrize(
    ("value", "kind", "unit", "said"),
    [
        (1.0, "continuous", "m", "1.00 m"),
        (-0.001, "continuous", "m", "0.00 m"),
        (3.14159, "toroidal", "rad", "180.0 deg"),
        (123.456, "continuous", "", "123.5"),
        (1.0, "boolean", "", "yes"),
        (0.0, "boolean", "", "no"),
        (2.0, "categorical", "", "2"),
        (float("nan"), "continuous", "m", "no value"),
    ],
)
def test_values_are_written_alike_with_their_units(value, kind, unit, said):
    assert measure(value, kind, unit) == said


def test_a_time_has_its_units():
    assert (duration(0.2), duration(59.0), duration(200.0)) == ("0 s", "59 s", "3 min 20 s")


def example(number: int, kind: str) -> Example:
    return Example("Start", (), "Stop", ExampleKind(kind), number, number)


def test_examples_that_count_and_those_superseded_add_up():
    kinds = ["demonstrated"] * 5 + ["default"] * 3
    some = [example(i, kind) for i, kind in enumerate(kinds)]
    assert counted(some) == "8 examples"
    more = [*some, example(8, "superseded"), example(9, "superseded")]
    assert counted(more) == "8 examples count, 2 are superseded"
    assert counted([some[0], more[-1]]) == "1 example counts, 1 is superseded"


def automaton(name: str, origin: str, *states: str) -> Learned:
    return Learned(name, origin, "", "", (), (), states, (), (), (), ())


@pytest.fixture
def page() -> Any:
    """Return a function that renders a panel for what a keeper performs."""

    async def made(panel: str, **known: Any) -> str:
        studio = Studio(lambda: Target(0))
        session: Session = studio.open()
        session.shared.store.known = Known(Target(0, "keepers", (ONE,)), **known)
        session.agent, session.tab = ONE, "learned"
        return render(panel, session)

    return lambda panel, **known: asyncio.run(made(panel, **known))


def performing(behavior: Learned, *path: str) -> dict[str, Any]:
    status = AgentStatus(
        agent=ONE, mode="performing", behavior=behavior.name, active_path=path, domain="soccer"
    )
    trained = frozenset({behavior.name} if behavior.origin == "trained" else ())
    watched = Watched(
        vocabulary=replace(Vocabulary(), domain="soccer", trained=trained),
        behaviors=MappingProxyType({behavior.name: behavior}),
    )
    return {
        "statuses": MappingProxyType({ONE: status}),
        "watched": MappingProxyType({ONE: watched}),
    }


@pytest.mark.parametrize(
    ("origin", "said"),
    [
        ("basic", "a basic behavior runs"),
        ("trained", "a saved automaton decides"),
        ("hand-written", "a hand-written automaton decides"),
    ],
)
def test_who_decides_is_said_as_it_is(page, origin, said):
    shown = page("overlay", **performing(automaton("Stop", origin, "Wait")))
    assert said in shown


def test_a_hand_written_automaton_that_was_taken_out_is_said_to_need_training(page):
    known = performing(automaton("GotoBall", "hand-written"), "Start")
    shown = page("side", **known)
    assert "is written by hand" not in shown
    assert "was taken out" in shown
    assert 'data-do="new" data-name="GotoBall"' in shown
    assert "does nothing until it is trained" in page("overlay", **known)
    whole = performing(automaton("GotoBall", "hand-written", "TurnToBall"), "TurnToBall")
    assert "is written by hand" in page("side", **whole)


def test_a_question_has_a_title_and_its_proposed_answer_comes_first(page):
    question = Question(
        number=3,
        kind=Question.CONTRADICTION,
        text="Stop or GoSlow?",
        choices=["Stop", "GoSlow"],
        effects=["removes example 5", "removes example 3"],
        proposed=1,
        features=["DistanceTo(ball)"],
        situation=[5.0],
    )
    training = replace(automaton("Asks", "training"), examples=(example(1, "demonstrated"),))
    watched = Watched(
        vocabulary=replace(
            Vocabulary(), domain="soccer", units={"DistanceTo": "m"}, kinds={"DistanceTo": "x"}
        ),
        training=training,
        questions=(question,),
    )
    status = AgentStatus(agent=ONE, mode="training", behavior="Asks", examples=1)
    known = {
        "statuses": MappingProxyType({ONE: status}),
        "watched": MappingProxyType({ONE: watched}),
    }

    async def made() -> str:
        session = Studio(lambda: Target(0)).open()
        session.shared.store.known = Known(Target(0, "keepers", (ONE,)), **known)
        session.agent = ONE
        return render("side", session)

    shown = asyncio.run(made())
    assert "Two commands disagree" in shown
    assert "<b>5.00 m</b>" in shown
    assert shown.index('data-test="answer-3-GoSlow"') < shown.index('data-test="answer-3-Stop"')
    assert shown.index('data-test="answer-3-Stop"') < shown.index('data-test="dismiss-3"')


# -- the emergency stop -----------------------------------------------------------------------


def test_the_emergency_stop_is_large_where_robots_may_do_harm_and_when_it_is_engaged(page):
    status = {"statuses": MappingProxyType({ONE: AgentStatus(agent=ONE, mode="idle")})}
    assert "large" in page("emergency", **status)
    assert "large" not in page("emergency", world=object(), **status)
    assert "large" not in page("emergency")
    stop = EmergencyStop(stamp=Time(sec=5), engaged=True, by="Anna", reason="a dog")
    assert "large" in page("emergency", world=object(), emergency=stop)
    assert 'data-test="release"' in page("emergency", emergency=stop)
    assert "Anna has stopped them (a dog)" in page("top", emergency=stop)
    released = EmergencyStop(stamp=Time(sec=6), engaged=False, by="Ben")
    assert 'data-test="stop-robots"' in page("emergency", emergency=released)
