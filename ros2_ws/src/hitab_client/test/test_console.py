"""Tables fit a terminal of 80 columns without losing anything, and are whole when piped."""

import io
import sys

from hitab_client import console


def test_what_is_kept_up_to_date_ends_with_its_last_state_in_a_pipe(capsys):
    with console.live("first") as update:
        update("second")
        update("last")
    assert capsys.readouterr().out.strip() == "last"


def test_a_terminal_that_cannot_go_back_gets_each_state_below_the_one_before(capsys, monkeypatch):
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setattr(console, "REPEAT_S", 0.0)
    with console.live("first") as update:
        update("first")
        update("second")
    assert capsys.readouterr().out == "first\nsecond\n"


def test_a_result_reaches_a_pipe_when_it_is_said(monkeypatch):
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written))
    console.say("Taught ApproachBall")
    assert written.getvalue() == b"Taught ApproachBall\n"
