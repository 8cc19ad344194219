"""Each operation and its service in `hitab_msgs` are the same thing, field by field."""

from dataclasses import fields
from typing import Any

import pytest
from hitab_msgs import msg, srv

from hitab_core.codec import from_dict
from hitab_core.operations import OPERATIONS
from hitab_core.training.operation import Operation, Outcome
from hitab_ros.messages.conversions import message_of, request_of

KINDS = {
    "str": {"string"},
    "bool": {"boolean"},
    "int": {"uint32", "uint64"},
    "float": {"double"},
    "Sequence[str]": {"sequence<string>"},
    "Sequence[int]": {"sequence<uint32>"},
    "Mapping[str, str]": {"sequence<diagnostic_msgs/KeyValue>"},
}
VALUES: dict[str, Any] = {
    "str": "text",
    "bool": True,
    "int": 7,
    "float": 0.5,
    "Sequence[str]": ("a", "b"),
    "Sequence[int]": (3, 4),
    "Mapping[str, str]": {"X": "ball"},
}
ANSWERED = ["success", "message", "remedies", "status"]


def fields_of(message: Any) -> dict[str, str]:
    return message.get_fields_and_field_types()


@pytest.mark.parametrize("kind", OPERATIONS.values(), ids=OPERATIONS)
def test_an_operation_and_its_service_agree(kind: type[Operation]) -> None:
    service = getattr(srv, kind.__name__)
    asked = fields_of(service.Request)
    own = {name: str(field.type) for name, field in kind.own_fields().items()}
    own |= {"id": "str", "by": "str"}
    assert list(asked) == list(own)
    assert {name for name, of in own.items() if asked[name] not in KINDS[of]} == set()

    answered = fields_of(service.Response)
    outcome = {field.name: str(field.type) for field in fields(Outcome)}
    assert list(answered)[:4] == ANSWERED
    assert {answered[name] for name in ANSWERED[1:]} == {
        "string",
        "sequence<hitab_msgs/Remedy>",
        "hitab_msgs/AgentStatus",
    }
    own_answer = {name: of for name, of in answered.items() if name not in ANSWERED}
    assert own_answer.keys() <= outcome.keys() - {"message", "remedies"}
    assert {n for n, of in own_answer.items() if of not in KINDS[outcome[n]]} == set()


def test_each_field_of_an_outcome_is_in_some_answer() -> None:
    answers = [fields_of(getattr(srv, kind.__name__).Response) for kind in OPERATIONS.values()]
    assert {field.name for field in fields(Outcome)} <= {name for one in answers for name in one}


def test_a_command_on_the_topic_has_the_fields_of_the_service() -> None:
    assert fields_of(msg.Command) == fields_of(srv.Command.Request)


@pytest.mark.parametrize("kind", OPERATIONS.values(), ids=OPERATIONS)
def test_an_operation_arrives_as_it_was_sent(kind: type[Operation]) -> None:
    given = {name: VALUES[str(field.type)] for name, field in kind.own_fields().items()}
    sent = kind(**given, id="5f", by="ann")
    assert from_dict(kind, request_of(sent)) == sent


def test_an_outcome_fills_in_what_the_answer_has() -> None:
    outcome = Outcome("done", digest="d", left="Start", examples=[1, 2], trimmed=["A"])
    saved = message_of(srv.SaveBehavior.Response, outcome)
    taught = message_of(srv.Command.Response, outcome)
    assert (saved.message, saved.digest, list(saved.trimmed)) == ("done", "d", ["A"])
    assert (taught.left, list(taught.examples)) == ("Start", [1, 2])
