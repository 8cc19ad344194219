"""Machines hear one another, and tell loss, delay and the difference of their clocks."""

from __future__ import annotations

import math

from hitab_msgs.msg import MachineLink, MachineStatus

from hitab_client.showing.machine_signs import HeardMachine
from hitab_ros.messages.stamps import seconds_of, time_of


def status(
    sequence: int, *, process: int = 1, links: tuple[MachineLink, ...] = ()
) -> MachineStatus:
    return MachineStatus(
        machine="there", process=process, sequence=sequence, links=list(links), stamp=time_of(0.0)
    )


def test_gaps_in_the_numbers_are_lost_messages() -> None:
    heard = HeardMachine()
    for number in (1, 2, 4, 5):
        heard.hear(status(number), "here", {})
    assert math.isclose(heard.loss, 0.2)
    heard.hear(status(1, process=2), "here", {})
    assert heard.loss == 0.0
    assert len(heard.processes) == 2


def test_the_fastest_answer_tells_delay_and_offset(monkeypatch: object) -> None:
    now = 1000.0
    import hitab_client.showing.machine_signs as module

    monkeypatch.setattr(module.time, "time", lambda: now)  # type: ignore[attr-defined]
    heard, ahead = HeardMachine(), 3.0
    for there, back in ((0.02, 0.02), (0.02, 0.5)):
        began = now
        arrived = began + there + ahead
        left = arrived + 0.1
        now = left - ahead + back
        link = MachineLink(machine="here", sequence=7, heard=time_of(arrived))
        answer = status(1, links=(link,))
        answer.stamp = time_of(left)
        heard.hear(answer, "here", {7: began})
    assert math.isclose(heard.delay, 0.02, abs_tol=1e-6)
    assert math.isclose(heard.offset, ahead, abs_tol=1e-6)
    assert math.isnan(HeardMachine().delay)
    assert seconds_of(heard.link().heard) == now
