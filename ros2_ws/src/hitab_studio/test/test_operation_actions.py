"""What a page asks for becomes an operation, by the table of operations."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from hitab_core.operations import (
    OPERATIONS,
    AnswerQuestion,
    DeleteExamples,
    Perform,
    RelabelExamples,
    RetimeExamples,
    SaveBehavior,
    SetCaution,
    Undo,
)
from hitab_core.training.operation import Operation
from hitab_studio.actions import REGISTERED_ACTIONS
from hitab_studio.actions.operation_actions import operation_of
from hitab_studio.pages.page_view import perform
from hitab_studio.studio import Studio
from hitab_studio.swarm.swarm_finder import SwarmTarget


def asked(data: dict[str, Any], *marked: int) -> tuple[list[Operation], Any]:
    """Return the operations that a request leads to, and its page."""
    done: list[Operation] = []

    async def made() -> Any:
        page = Studio(lambda: SwarmTarget(0)).open()
        page.table.marked = {*marked}

        async def do(operation: Operation) -> Any:
            done.append(operation)
            return SimpleNamespace(message="deleted 3; it has 2 examples", remedies=[])

        page.do = do  # type: ignore[method-assign]
        await perform(page, data)
        return page

    return done, asyncio.run(made())


def test_each_operation_has_an_action_of_its_name():
    assert OPERATIONS.keys() <= REGISTERED_ACTIONS.keys()


@pytest.mark.parametrize(
    ("data", "operation"),
    [
        ({"do": "undo"}, Undo()),
        ({"do": "perform"}, Perform()),
        ({"do": "delete_examples", "numbers": "12"}, DeleteExamples([12])),
        ({"do": "delete_examples"}, DeleteExamples([3, 5])),
        (
            {"do": "relabel_examples", "field": "next_state", "value": "Stop"},
            RelabelExamples([3, 5], "Stop"),
        ),
        (
            {"do": "retime_examples", "numbers": "3", "field": "ago", "value": "0.4"},
            RetimeExamples([3], 0.4),
        ),
        ({"do": "answer_question", "number": "2", "choice": "Go"}, AnswerQuestion(2, "Go")),
        (
            {"do": "answer_question", "number": "2", "dismiss": "yes"},
            AnswerQuestion(2, dismiss=True),
        ),
        (
            {"do": "set_caution", "values": {"when_unsure": "halt", "distance": "2"}},
            SetCaution("halt", 2.0),
        ),
    ],
)
def test_keys_and_inputs_are_the_fields_of_an_operation(data, operation):
    done, page = asked(data, 5, 3)
    assert done == [operation]
    assert page.table.marked == {3, 5} - {*getattr(operation, "numbers", ())}
    assert page.messages.shown[0].text == "deleted 3\nit has 2 examples"


def test_an_operation_has_the_identity_of_its_request_which_may_come_again():
    assert asked({"do": "undo", "id": "a.7"})[0] == [Undo(id="a.7")]


def test_inputs_of_targets_are_pairs_and_those_left_empty_are_none():
    page: Any = SimpleNamespace(table=SimpleNamespace(marked=set()))
    values = {"automaton": " Near ", "bindings:ball": "A", "bindings:goal": " "}
    saved = operation_of(SaveBehavior, page, {"values": {**values, "keep_unused": "on"}})
    assert saved == SaveBehavior("Near", {"ball": "A"}, keep_unused=True)


def test_what_is_no_number_is_refused_by_name():
    done, page = asked({"do": "retime_examples", "numbers": "3", "field": "ago", "value": "now"})
    assert not done
    assert page.messages.shown[0].text == "Give ago as a number."
