"""What rcssserver says is read, and what it cannot have said is refused, never anything worse."""

import contextlib
import gzip
import json
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_rcssserver import messages
from hitab_rcssserver.messages import ProtocolError, decode, parse, parse_message

TRANSCRIPT = Path(__file__).parent / "data" / "keepaway_transcript.jsonl.gz"


@pytest.fixture(scope="module")
def transcript():
    with gzip.open(TRANSCRIPT, "rt") as lines:
        return [json.loads(line) for line in lines]


@pytest.fixture(scope="module")
def received(transcript):
    return [parse_message(line["msg"]) for line in transcript if line["dir"] == "recv"]


def of(kind, received):
    return [message for message in received if isinstance(message, kind)]


def test_every_message_of_the_transcript_is_read(received):
    counts = Counter(type(message).__name__ for message in received)
    assert counts == {
        "Init": 2, "Settings": 2, "NoneType": 38, "SenseBody": 1345, "FullState": 1345,
        "Think": 1345, "See": 896, "Hear": 89,
    }  # fmt: skip


def test_server_parameters_are_known_by_name(received):
    server = of(messages.Settings, received)[0]
    assert server.number("synch_mode", 0) == 1
    assert server.number("keepaway_length", 0) == 20
    assert server.number("no such setting", 7) == 7
    with pytest.raises(ProtocolError, match="not a number"):
        server.number("team_l_start", 0)


def test_a_full_state_holds_everybody(received):
    state = parse_message(
        "(fullstate 628 (pmode play_on) (score 0 0) ((b) -7.6 9.9 -0.5 1.0)"
        " ((p l 1 0) -2.9 1.8 0.01 -0.03 110.2 0 (stamina 8000 1 1 122400) k))"
    )
    assert state.ball == (-7.6, 9.9, -0.5, 1.0)
    assert state.players == (
        messages.PlayerState("l", 1, -2.9, 1.8, 0.01, -0.03, 110.2, kicked=True),
    )
    playing = [state for state in of(messages.FullState, received) if state.mode == "play_on"]
    assert {len(state.players) for state in playing} == {5}
    assert [state.time for state in playing][::2][:3] == [0, 1, 2]


def test_a_kick_is_marked_in_the_cycle_in_which_it_is_counted(transcript):
    counted = marked = before = 0
    for line in transcript:
        if line["client"] != 0 or line["dir"] != "recv":
            continue
        message = parse_message(line["msg"])
        if isinstance(message, messages.SenseBody):
            counted, before = message.kicks - before, message.kicks
        elif isinstance(message, messages.FullState):
            me = next((p for p in message.players if (p.side, p.number) == ("l", 1)), None)
            assert me is not None
            assert me.kicked == bool(counted)
            marked += me.kicked
    assert marked == 27


def test_what_is_heard_has_a_sender_and_what_is_seen_a_name_in_parts(received):
    heard = of(messages.Hear, received)
    over = [h.time for h in heard if h.text == messages.EPISODE_OVER]
    assert over == [190, 190, 383, 383, 629, 629]
    assert messages.Hear(41, "1", "p1", "our") in heard
    assert messages.Hear(77, "self", "p2") in heard
    assert messages.Hear(41, "-3", "p1", "opp") in heard
    seen = of(messages.See, received)[-1]
    assert messages.SeenObject(("b",), 11, 5, 1.1, -1.1) in seen.objects
    assert any(thing.name == ("p", "takers", "2") for thing in seen.objects)


def test_what_the_server_cannot_have_said_is_refused_with_the_reason():
    for text, why in [
        ("", "empty"),
        ("hello", "does not begin"),
        ("()", "without a name"),
        ("((a))", "without a name"),
        ("(init l 1 x", "not closed"),
        ("(think)(think)", "followed"),
        ("(think))", "followed"),
        ('(hear 1 self "x)', "quote is not closed"),
        ("(init)", "index out of range"),
        ("(init x 1 play_on)", "no such side"),
        ("(sense_body 3)", "speed"),
        ("(sense_body 3.5 (speed 0 0) (head_angle 0) (kick 0))", "whole number"),
        ("(fullstate 1 (pmode play_on))", "no ball"),
        ("(fullstate 1 (pmode play_on) ((b) 1 2 3 nan))", "not finite"),
        ("(fullstate 1 (pmode play_on) ((b) 1 2 3))", "is missing"),
        ("(see 1 ((b)))", "missing"),
        ("(see 1 (b 3 4))", "where a list should be"),
        ("(hear 1 north our 3 x)", "not a number"),
        ("(hear " + "(" * 10_000 + ")" * 10_000 + " 1)", "where a word should be"),
    ]:
        with pytest.raises(ProtocolError, match=why):
            parse_message(text)


MESSAGE_LIKE = st.recursive(
    st.sampled_from([
        "init", "fullstate", "see", "hear", "sense_body", "server_param", "pmode", "b", "p", "l",
        "r", "k", "speed", "kick", "head_angle", "ok", "1", "-3.5", "nan", "1e999", '"', '"a b"',
        "referee",
    ]) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=6).map(lambda parts: f"({' '.join(parts)})"),
    max_leaves=40,
)  # fmt: skip


@given(MESSAGE_LIKE | st.text() | st.text(alphabet='()" a1'))
def test_any_text_is_a_message_or_a_protocol_error(text):
    with contextlib.suppress(ProtocolError):
        parse_message(text)


@given(st.binary())
def test_any_datagram_is_text_or_a_protocol_error(datagram):
    assert decode(b"(think)\0") == "(think)"
    with contextlib.suppress(ProtocolError):
        parse(decode(datagram))
