"""A repeated request is recognized and not carried out again."""

from types import SimpleNamespace

import pytest
from hitab_ros.recent_requests import RecentRequests

from hitab_core.errors import HitabError
from hitab_ros import recent_requests
from hitab_ros.answering import answering
<<<<<<< HEAD
=======
from hitab_ros.recent_requests import RecentRequests
from hitab_ros.timing import ANSWER_S
>>>>>>> presence


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def ask(answer, **fields) -> str:
    return answer(SimpleNamespace(**fields), SimpleNamespace(message="", success=False)).message


def test_a_request_is_recognized_by_its_client_and_number_for_a_while():
    clock = Clock()
    recent = RecentRequests(clock)
    recent.keep("ann", 1, "first")
    assert recent.came_of("ann", 1) == "first"
    assert recent.came_of("ben", 1) is None  # two clients count for themselves
    assert recent.came_of("ann", 2) is None
    clock.now += 4 * ANSWER_S + 1
    assert recent.came_of("ann", 1) is None


def test_memory_does_not_grow_without_end(monkeypatch):
    monkeypatch.setattr(recent_requests, "ANSWERS_MAX", 3)
    recent = RecentRequests()
    for number in range(1, 10):
        recent.keep("ann", number, str(number))
    assert [n for n in range(1, 10) if recent.came_of("ann", n)] == [7, 8, 9]


def test_a_service_does_a_numbered_request_once_and_refuses_it_once():
    done: list[str] = []

    def serve(request, response) -> str:
        done.append(request.what)
        if request.what == "wrong":
            raise HitabError(f"refused, {len(done)}")
        return f"did {request.what}, {len(done)}"

    answer = answering(serve)
    assert ask(answer, what="undo", request=5, client="ann") == "did undo, 1"
    assert ask(answer, what="undo", request=5, client="ann") == "did undo, 1"
    assert ask(answer, what="undo", request=5, client="ben") == "did undo, 2"
    for _ in range(2):
        with pytest.raises(HitabError, match="refused, 3"):
            ask(answer, what="wrong", request=6, client="ann")
    # Plain `ros2 service call`, and services that change nothing, have no numbers.
    assert ask(answer, what="undo", request=0, client="") == "did undo, 4"
    assert ask(answer, what="undo", request=0, client="") == "did undo, 5"
    assert ask(answer, what="list") == "did list, 6"
