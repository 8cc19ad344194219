"""Keys of a terminal, one at a time and without Enter; the terminal is restored at the end."""

from __future__ import annotations

import codecs
import os
import re
import select
import termios
import tty
from typing import Self

ARROW_NAMES = {"A": "up", "B": "down", "C": "right", "D": "left"}
_SEQUENCE = re.compile(r"\x1b(?:\[([0-9;?]*)([@-~])|O(.))", re.DOTALL)
_BEGUN = re.compile(r"\x1b(?:\[[0-9;?]*|O)?\Z")
"""Incomplete escape sequence; a lone Escape looks the same."""

SHIFT = "2"  # the modifier in sequences such as ESC [ 1 ; 2 D
ESCAPE = "escape"
END = "end"
"""Key for the end: the terminal is gone, or the person has pressed Ctrl-D."""

_READ_MAX = 4096


def keys_in(text: str) -> tuple[list[str], str]:
    r"""Return the keys in a terminal's input, and the incomplete rest.

    Characters are keys by themselves; arrow keys are ``up``, ``shift-left`` and so on. Sequences
    of other keys are left out.

    Examples:
        >>> keys_in("a\x1b[A\x1b[1;2D\x1b[15~b\x1b[")
        (['a', 'up', 'shift-left', 'b'], '\x1b[')
    """
    found: list[str] = []
    place = 0
    while place < len(text):
        if match := _SEQUENCE.match(text, place):
            arrow = ARROW_NAMES.get(match[2] or match[3])
            if arrow:
                shifted = (match[1] or "").partition(";")[2] == SHIFT
                found.append(f"shift-{arrow}" if shifted else arrow)
            place = match.end()
        elif _BEGUN.match(text, place):
            return found, text[place:]
        else:
            found.append(ESCAPE if text[place] == "\x1b" else text[place])
            place += 1
    return found, ""


class TerminalKeys:
    r"""Reads keys as they are pressed; a context manager that restores the terminal.

    Ctrl-C still interrupts. Ctrl-Z and Ctrl-\ do nothing meanwhile, since a person who drives a
    robot must not lose the keys.

    Args:
        terminal: file descriptor, open for reading.
    """

    def __init__(self, terminal: int) -> None:
        self._terminal = terminal
        self._decode = codecs.getincrementaldecoder("utf-8")("replace").decode
        self._rest = ""

    def __enter__(self) -> Self:
        self._before = termios.tcgetattr(self._terminal)
        tty.setcbreak(self._terminal)
        now = termios.tcgetattr(self._terminal)
        for key in (termios.VSUSP, termios.VQUIT):
            now[6][key] = b"\x00"  # _POSIX_VDISABLE of Linux
        termios.tcsetattr(self._terminal, termios.TCSANOW, now)
        return self

    def __exit__(self, *error: object) -> None:
        # Discards unread input, which the shell must not run.
        termios.tcsetattr(self._terminal, termios.TCSAFLUSH, self._before)

    def read(self) -> list[str]:
        """Return the keys that were pressed since the last call, without waiting.

        If the terminal is gone, or on Ctrl-D, the last key is `END`.
        """
        found: list[str] = []
        if not select.select([self._terminal], [], [], 0)[0]:
            if self._rest:  # nothing followed: the Escape key
                found, self._rest = [ESCAPE], ""
            return found
        try:
            data = os.read(self._terminal, _READ_MAX)
        except OSError:
            data = b""
        if not data:
            return [END]
        found, self._rest = keys_in(self._rest + self._decode(data))
        return [*found[: found.index("\x04")], END] if "\x04" in found else found
