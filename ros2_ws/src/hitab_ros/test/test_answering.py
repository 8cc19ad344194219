"""A request to a world that is sent again is not carried out again."""

from types import SimpleNamespace

import pytest

from hitab_core import operation
from hitab_core.texts.errors import HitabError
from hitab_ros.answering import answering


def ask(answer, what: str, id: str = "") -> str:
    request = SimpleNamespace(what=what, id=id)
    return answer(request, SimpleNamespace(message="", success=False)).message


def test_a_service_does_a_request_of_an_id_once_and_may_do_one_that_it_refused(monkeypatch):
    done: list[str] = []

    def serve(request, response) -> str:
        done.append(request.what)
        if request.what == "wrong" and len(done) < 4:
            raise HitabError(f"refused, {len(done)}")
        return f"did {request.what}, {len(done)}"

    answer = answering(serve)
    for _ in range(2):
        assert ask(answer, "step", "a") == "did step, 1"
    for number in (2, 3):
        with pytest.raises(HitabError, match=f"refused, {number}"):
            ask(answer, "wrong", "b")
    for _ in range(2):
        assert ask(answer, "wrong", "b") == "did wrong, 4"
    # A plain `ros2 service call` has no id.
    assert [ask(answer, "step") for _ in range(2)] == ["did step, 5", "did step, 6"]
    monkeypatch.setattr(operation, "OUTCOMES_MAX", 3)
    for id in "cdef":
        ask(answer, "step", id)
    assert ask(answer, "step", "a") == "did step, 11", "the memory is bounded"
