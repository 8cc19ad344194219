"""Keys of a terminal arrive as they are pressed, and the terminal is restored at the end."""

import os
import pty
import signal
import subprocess
import sys
import termios

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_cli.views.terminal_keys import END, ESCAPE, TerminalKeys, keys_in

KEYS = {
    "a": "a",
    "S": "S",
    "ä": "ä",
    "\x1b[A": "up",
    "\x1bOB": "down",
    "\x1b[C": "right",
    "\x1b[1;2D": "shift-left",
}


@given(st.lists(st.sampled_from(sorted(KEYS))), st.integers(1, 4))
def test_keys_are_the_same_however_their_bytes_arrive(sent, size):
    text, found, rest = "".join(sent), [], ""
    for start in range(0, len(text), size):
        keys, rest = keys_in(rest + text[start : start + size])
        found += keys
    assert found == [KEYS[key] for key in sent]
    assert rest == ""


@given(st.text("\x1b[O1;2ABCDxyz~\x00\x7f", max_size=20))
def test_no_text_is_too_strange(text):
    found, rest = keys_in(text)
    assert all(key for key in found)
    assert text.endswith(rest)


def term(screen: int, terminal: int) -> None:
    """Press keys, and fail."""
    before = termios.tcgetattr(terminal)
    with TerminalKeys(terminal) as keys:
        assert keys.read() == []
        os.write(screen, "ä\x1b".encode())
        assert keys.read() == ["ä"]
        assert keys.read() == [ESCAPE], "nothing follows"
        os.write(screen, b"q\x1a\x04")
        assert keys.read() == ["q", "\x1a", END], "it is not suspended by Ctrl-Z"
        assert termios.tcgetattr(terminal) != before
        raise RuntimeError


def test_a_terminal_is_left_as_it_was_found_whatever_happens():
    screen, terminal = pty.openpty()
    before = termios.tcgetattr(terminal)
    with pytest.raises(RuntimeError):
        term(screen, terminal)
    assert termios.tcgetattr(terminal) == before
    os.close(screen)
    os.close(terminal)


WAITS = """
import time
from hitab_cli.views.terminal_keys import TerminalKeys
from hitab_client.terminal.interruptions import handle_interruptions
handle_interruptions()
with TerminalKeys(0):
    print("ready", flush=True)
    time.sleep(60)
"""


def test_a_terminal_is_left_as_it_was_found_by_what_is_ended():
    screen, terminal = pty.openpty()
    before = termios.tcgetattr(terminal)
    process = subprocess.Popen(
        [sys.executable, "-c", WAITS],
        stdin=terminal,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    assert termios.tcgetattr(terminal) != before
    process.send_signal(signal.SIGTERM)
    process.communicate()
    assert process.returncode
    assert termios.tcgetattr(terminal) == before
    os.close(screen)
    os.close(terminal)
