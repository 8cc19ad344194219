"""Who is silent: any message shows that a process lives, and who was held up blames nobody."""

from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import Alive, HostRoster

from hitab_ros import Presence, SignsOfLife, presence
from hitab_ros.timing import POLL_S, SILENT_AFTER_S


class Clock:
    now = 0.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(presence, "time", clock)
    return clock


def silent_after(clock: Clock, signs: Presence, seconds: float, *sending: str) -> set[str]:
    for _ in range(int(seconds / POLL_S) + 1):
        clock.now += POLL_S
        signs.hear_known(sending)
        signs.silent()
    return set(signs.silent())


def listening() -> tuple[SignsOfLife, Any, Any]:
    takes = list[Any]()
    node: Any = SimpleNamespace(
        create_subscription=lambda kind, topic, take, qos: takes.append(take)
    )
    return SignsOfLife(node, "", lambda name, swarm: swarm != "other"), *takes


def test_what_sends_something_else_than_signs_is_not_silent(clock):
    signs, _, sign = listening()
    for name in ("world", "keeper_1"):
        sign(Alive(process=name))
    assert silent_after(clock, signs, 0.5 * SILENT_AFTER_S) == set()
    assert silent_after(clock, signs, 2 * SILENT_AFTER_S, "world") == {"keeper_1"}
    assert silent_after(clock, signs, 2 * SILENT_AFTER_S, "keeper_1") == {"world"}
    signs.hear_known(["other"])
    assert "other" not in silent_after(clock, signs, 2 * SILENT_AFTER_S), "it never gave a sign"


def test_the_agents_of_a_host_are_silent_with_it_and_the_host_itself_is_no_agent(clock):
    signs, roster, sign = listening()
    sign(Alive(process="host"))
    roster(HostRoster(host="host", agents=["a", "b"]))
    sign(Alive(process="host"))
    sign(Alive(process="b", swarm="other"))
    assert silent_after(clock, signs, 0.5 * SILENT_AFTER_S) == set()
    assert silent_after(clock, signs, SILENT_AFTER_S) == {"a", "b"}
    sign(Alive(process="host"))
    assert signs.silent() == {}


def test_who_was_suspended_takes_nobody_for_silent(clock):
    signs = Presence()
    signs.hear("a")
    clock.now += 100 * SILENT_AFTER_S
    assert signs.silent() == {}
    assert silent_after(clock, signs, SILENT_AFTER_S) == {"a"}


def test_who_has_gone_is_silent_at_once_until_it_is_back(clock):
    signs = Presence()
    signs.hear("a")
    signs.set_gone(["a", "b"])
    clock.now += POLL_S
    assert signs.silent() == {"a": POLL_S, "b": POLL_S}
    signs.set_gone(["b"])
    clock.now += POLL_S
    assert signs.silent() == {"b": 2 * POLL_S}


def test_a_start_is_given_time_before_its_first_sign(clock):
    signs = Presence()
    signs.hear("relay", due_in_s=2 * SILENT_AFTER_S)
    assert signs.age("relay") < 0.0 < signs.age("nobody")
    assert silent_after(clock, signs, 2 * SILENT_AFTER_S) == set()
    assert silent_after(clock, signs, SILENT_AFTER_S) == {"relay"}
