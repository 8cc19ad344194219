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
from hitab_studio.finding import Target
from hitab_studio.known import Known
from hitab_studio.learned import Vocabulary
from hitab_studio.session import Session
from hitab_studio.studio import Studio
from hitab_studio.views import render
from hitab_studio.views.numbers import measure
from hitab_studio.watching import Watched

ONE = "keeper_1"


def test_values_are_written_alike_with_their_units():
    for value, kind, unit, said in [
        (1.0, "continuous", "m", "1.00 m"),
        (-0.001, "continuous", "m", "0.00 m"),
        (3.14159, "toroidal", "rad", "180.0 deg"),
        (123.456, "continuous", "", "123.5"),
        (1.0, "boolean", "", "yes"),
        (0.0, "boolean", "", "no"),
        (2.0, "categorical", "", "2"),
        (float("nan"), "continuous", "m", "no value"),
    ]:
        assert measure(value, kind, unit) == said


def example(number: int, kind: str) -> Example:
    return Example("Start", (), "Stop", ExampleKind(kind), number, number)


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
