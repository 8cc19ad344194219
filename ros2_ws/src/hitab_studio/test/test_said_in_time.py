"""The page warns a person in time, and in the place where the person looks."""

import asyncio
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus, TrainingStatus

from hitab_client import Learned, SwarmError
from hitab_core import Example, Term
from hitab_core.example import ExampleKind
from hitab_core.operations import BeginTraining
from hitab_core.training.operation import Operation
from hitab_ros.call import RequestRefused, blocking
from hitab_studio.actions import teaching_actions
from hitab_studio.pages.page import Page
from hitab_studio.pages.page_parts import LostCommand
from hitab_studio.pages.page_view import RequestQueue, perform
from hitab_studio.studio import Studio
from hitab_studio.swarm.agent_watch import AgentState
from hitab_studio.swarm.received_vocabulary import Vocabulary
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState
from hitab_studio.views import render

ONE = "keeper_1"
UP = SwarmTarget(0, "keepaway", (ONE,), 1, folder="/keepaway", world=True)
SAVED = Learned(
    "FetchBall",
    (Term("Stop"),),
    (),
    {},
    examples=tuple(
        Example("Start", (), "Stop", ExampleKind.DEMONSTRATED, i, i) for i in (1, 2, 3)
    ),
)
WORDS = Vocabulary(
    domain="soccer",
    trained=frozenset({"FetchBall"}),
    features=("DirectionTo(X)",),
    kinds={"DirectionTo": "toroidal"},
    units={"DirectionTo": "rad"},
    targets=("ball",),
)


def page(known: SwarmState, term: Any) -> Any:
    async def made() -> Any:
        page = Studio(lambda: SwarmTarget(0)).open()
        page.studio.known = known
        page.agent = ONE
        return await term(page)

    return asyncio.run(made())


def keeper(status: AgentStatus | None = None, **watched: Any) -> SwarmState:
    known = AgentState(vocabulary=WORDS, behaviors={"FetchBall": SAVED}, **watched)
    idle = AgentStatus(agent=ONE, mode="idle", domain="soccer")
    return SwarmState(UP, statuses={ONE: status or idle}, watched=MappingProxyType({ONE: known}))


# -- a command that was not taken, while more was asked for -----------------------------------


@pytest.mark.parametrize("is_refused", [True, False])
def test_what_was_pressed_before_a_command_was_said_to_be_lost_does_nothing_else(
    monkeypatch, is_refused
):
    """Undo took back the command before it, and the offer to send it again went to the next."""
    done: list[str] = []
    ids: list[str] = []
    training = TrainingStatus(automaton="Chase")
    status = AgentStatus(agent=ONE, mode="training", training=training)
    failing = ["Stop"]

    async def command(*given: Any, id: str, by: str, **_: Any) -> None:
        assert by == "Anna"
        behavior = given[-1]
        if behavior == "Stop":
            ids.append(id)
        if behavior in failing:
            raise (
                RequestRefused("it is stopped")
                if is_refused
                else SwarmError("no answer within 2 s")
            )
        done.append(behavior)

    async def do(agent: str, operation: Operation) -> Any:
        assert operation.by == "Anna"
        done.append(operation.name)
        return SimpleNamespace(message="done", remedies=[])

    async def term(page: Page) -> None:
        page.set_demonstrator("Anna")
        agents = SimpleNamespace(do=SimpleNamespace(coroutine=do))

        async def asked(what: Any, needs: str = "") -> Any:
            return await what(SimpleNamespace(agents=agents, world=None))

        monkeypatch.setattr(page, "ask", asked)
        monkeypatch.setattr(teaching_actions.demonstrating, "command", blocking(command))
        requests, seen = RequestQueue(), asyncio.Event()
        performing = asyncio.create_task(
            requests.perform(page, lambda: requests.waiting or seen.set())
        )

        async def ask(*asked: str) -> None:
            for what in asked:
                is_command = what[0].isupper()
                requests.add({"do": "command", "behavior": what} if is_command else {"do": what})
            seen.clear()
            await asyncio.wait_for(seen.wait(), 30.0)

        await ask("GoFast", "Stop", "earlier", "GoSlow", "undo", "undo")
        assert done == ["GoFast"]
        (said,) = [m for m in page.messages.shown if "Left out" in m.text]
        assert said.text == "Left out what was pressed after Stop, which was not taken."
        assert said.times == 4
        if is_refused:
            assert page.lost is None
        else:
            assert page.lost is not None
            assert page.lost.behavior == "Stop"
            failing.clear()
            await ask("send-again")
            assert page.lost is None
            assert len(ids) == 2
            assert ids[0] == ids[1] != "", "it would be done twice"
            assert done.pop() == "Stop"
        await ask("undo", "GoSlow", "undo")
        assert done == ["GoFast", "undo", "GoSlow", "undo"]
        requests.close()
        await performing

    page(keeper(status), term)


def test_a_target_may_be_pressed_before_the_page_has_asked_for_it(monkeypatch):
    """Otherwise the key would command a behavior."""

    async def term(page: Page) -> None:
        done: list[str] = []

        async def commanded(page: Page, sent: LostCommand, seen: int) -> None:
            done.append(sent.behavior)

        monkeypatch.setattr(teaching_actions, "_commanded", commanded)
        await perform(page, {"do": "command", "behavior": "GoTo(A)", "hotkey": "2"})
        await perform(page, {"do": "command", "behavior": "GoFast", "hotkey": "1"})
        assert done == ["GoTo(ball)"]
        await perform(page, {"do": "command", "behavior": "GoTo(A)", "hotkey": "2"})
        await perform(page, {"do": "command", "behavior": "GoFast"})
        assert done == ["GoTo(ball)", "GoFast"]
        assert page.missing_targets is None

    page(keeper(), term)


# -- a name that is taken ---------------------------------------------------------------------


def test_who_begins_before_that_was_said_is_told_and_may_begin_then(monkeypatch):
    async def term(page: Page) -> None:
        begun = []

        async def do(operation: Operation) -> Any:
            begun.append(operation)
            return SimpleNamespace(message='training "FetchBall"', remedies=[])

        monkeypatch.setattr(page, "do", do)
        values = {"automaton": "FetchBall", "features": ["Done"], "states": ["Stop"]}
        begin = {"do": "begin_training", "id": "7", "values": values}
        await perform(page, {"do": "new"})
        await perform(page, begin)
        said = render("dialog", page)
        assert not begun
        assert 'data-test="saved-already"' in said
        assert "Begin replaces it" in said
        await perform(page, begin)
        assert begun == [BeginTraining("FetchBall", ["Done"], ["Stop"], id="7")]
        assert page.messages.shown[-1].text == 'training "FetchBall"'

    page(keeper(), term)


def test_what_was_typed_last_opens_no_dialog_that_is_closed():
    """An empty dialog took the Esc that was meant for the training."""

    async def term(page: Page) -> None:
        for late in ("new-name", "new-parameter"):
            await perform(page, {"do": late, "value": "A"})
            assert page.dialog == {}

    page(keeper(), term)
