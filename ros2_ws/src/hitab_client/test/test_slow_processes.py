"""A slow process is not silent: any message shows that it is alive."""

from types import SimpleNamespace
from typing import Any

from hitab_msgs.msg import Alive

from hitab_client import SignsOfLife, signs_of_life
from hitab_client.signs_of_life import GAP_SECONDS, SILENT_AFTER_SECONDS


class Clock:
    now = 0.0

    def monotonic(self) -> float:
        return self.now


def test_what_sends_something_else_than_signs_is_not_silent(monkeypatch):
    clock, takes = Clock(), list[Any]()
    monkeypatch.setattr(signs_of_life, "time", clock)
    link: Any = SimpleNamespace(subscribe=lambda kind, topic, take, qos: takes.append(take))
    signs = SignsOfLife(link)
    for name in ("world", "keeper_1"):
        takes[-1](Alive(process=name))

    def silent_after(seconds: float, *sending: str) -> set[str]:
        for _ in range(int(seconds / GAP_SECONDS) + 1):
            clock.now += GAP_SECONDS
            signs.take_signs_of(sending)
            signs.silent()
        return set(signs.silent())

    assert silent_after(0.5 * SILENT_AFTER_SECONDS) == set()
    assert silent_after(2 * SILENT_AFTER_SECONDS, "world") == {"keeper_1"}
    assert silent_after(2 * SILENT_AFTER_SECONDS, "keeper_1") == {"world"}
    signs.take_signs_of(["other"])
    assert "other" not in silent_after(2 * SILENT_AFTER_SECONDS), "it never gave a sign"
