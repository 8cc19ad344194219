"""Invalid messages are refused, with the field's name, before any callback receives them."""

from __future__ import annotations

import time

import pytest
from hitab_msgs import msg, srv
from hypothesis import given
from hypothesis import strategies as st
from std_msgs.msg import String

from hitab_ros.messages.checks import BadMessage, check
from hitab_ros.messages.plain_text import plain

FAR = time.time_ns() + 365 * 24 * 3600 * 10**9

BAD = [
    (msg.HostRoster(host="no topic name"), 'HostRoster.host: "no topic name" is not a name'),
    (msg.HostRoster(host=".."), "HostRoster.host"),
    (msg.HostRoster(host="h", agents=["a", "../b"]), 'HostRoster.agents: "../b" is not a name'),
    (msg.HostRoster(host="h", agents=["a"] * 50_000), "HostRoster.agents has 50000 items"),
    (msg.HostRoster(host="h", number=FAR), "HostRoster.number"),
    (msg.Command(behavior="x" * 100_000), "Command.behavior has 100000 characters"),
    (msg.Command(targets=["ball", "a\x00b"]), "Command.targets"),
    (msg.Command(by="\x1b[31m"), r'"\x1b[31m" has control characters'),
    (msg.Order(epoch=2**63), "h ahead of this machine's clock"),
    (msg.Order(report_period=float("inf")), "Order.report_period is infinite"),
    (msg.Reports(reports=[msg.Report(), msg.Report(epoch=FAR)]), "Report.epoch"),
    (msg.Distribution(files=[msg.BehaviorFile(name="a\nb")]), r'"a\nb" has control characters'),
    (srv.Place.Request(entities=[msg.Entity(name="a\x00")]), "Entity.name"),
    (srv.LoadLibrary.Request(path="/" * 5000), "LoadLibrary_Request.path has 5000 characters"),
    (srv.SaveBehavior.Request(description="a\x00"), "SaveBehavior_Request.description"),
    (msg.Percept(cycle=2**60), "Percept.cycle is 1152921504606846976; no world counts beyond"),
    (msg.PerceptBatch(cycle=10**15 + 1), "PerceptBatch.cycle is 1000000000000001"),
    (msg.Command(seen=2**64 - 1), "Command.seen"),
]


def test_it_is_refused():
    for message, why in BAD:
        with pytest.raises(BadMessage) as error:
            check(message)
        assert why in str(error.value)
        assert len(str(error.value)) < 300
        assert "\n" not in str(error.value)


GOOD = [
    msg.Command(behavior="GoTo(ball)", by="Zoë O'Hara"),
    msg.HostRoster(host="host_1a2b", number=time.time_ns(), agents=["ant_1"] * 10_000),
    msg.Order(epoch=time.time_ns()),
    msg.Report(values=[float("nan"), float("inf")], position=[float("inf"), 0.0]),
    msg.Percept(values=[float("inf")] * 1000, heard=["here!"], cycle=10**15),
    msg.Distribution(files=[msg.BehaviorFile(name="A", text="format: 1\n" * 100_000)]),
    msg.AgentStatus(last_error="line 1\nline 2", faults=["a\nb"]),
    srv.Place.Request(entities=[msg.Entity(name="ball", x=1.0, y=float("nan"))]),
    srv.SaveBehavior.Request(description="Two\nlines."),
    String(data="\x00" * 100_000),  # not ours
]


def test_what_can_be_meant_passes():
    for message in GOOD:
        check(message)


def test_each_message_and_service_of_the_project_can_be_checked():
    kinds = [getattr(msg, name) for name in dir(msg) if name[0].isupper()]
    services = [getattr(srv, name) for name in dir(srv) if name[0].isupper()]
    kinds += [service.Request for service in services if hasattr(service, "Request")]
    for kind in kinds:
        if kind is not msg.HostRoster:  # whose name must not be empty
            check(kind())


@given(st.text(alphabet=st.characters(codec="utf-8"), max_size=3000))
def test_a_status_with_any_text_made_plain_passes(text):
    """Otherwise every receiver would drop a status that quotes a foreign text."""
    quoted = plain(text)
    name = plain(text, 200, lines=False)
    assert len(quoted) <= 1000
    assert len(name) <= 200
    training = msg.TrainingStatus(demonstrator=name)
    check(msg.AgentStatus(training=training, last_error=quoted, faults=[quoted], note=quoted))


def test_a_short_printable_text_stays_as_it_is_and_others_can_be_read():
    assert plain("Zoë\nO'Hara") == "Zoë\nO'Hara"
    assert plain("a\nb\x1b[31m", lines=False) == r"a\nb\x1b[31m"
    assert plain("x" * 2000, 11) == "xxx ... xxx"
