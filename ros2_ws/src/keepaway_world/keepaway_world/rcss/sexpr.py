"""S-expressions, the form of all messages of rcssserver: ``(hear 41 1 our 3 "p1")``."""

from __future__ import annotations

import re
from typing import TypeAlias

LENGTH_MAX = 65_536
"""Longest message that is read, in characters; a UDP datagram is not longer."""

DEPTH_MAX = 32
"""Deepest nesting that is read; the server's own messages nest four deep."""

Expression: TypeAlias = "str | list[Expression]"
"""An atom or a list. Numbers stay text; quoted texts lose their quotes."""

_TOKEN = re.compile(r'[()]|"[^"]*"|[^\s()"]+|"')


class ProtocolError(ValueError):
    """A message that is not rcssserver's; the text says what is wrong with it."""


def excerpt(text: str, length: int = 60) -> str:
    """Return the printable beginning of a message, for an error's text."""
    shown = text if len(text) <= length else text[: length - 3] + "..."
    return repr(shown)


def decode(datagram: bytes) -> str:
    """Return the text of a datagram without its trailing NULs and line ends.

    Raises:
        ProtocolError: if it is not ASCII.
    """
    try:
        return datagram.rstrip(b"\0\r\n").decode("ascii")
    except UnicodeDecodeError:
        shown = excerpt(datagram.decode("latin-1"))
        raise ProtocolError(f"not a message of rcssserver, which speaks ASCII: {shown}") from None


def parse(text: str) -> list[Expression]:
    """Return a message as a list.

    Raises:
        ProtocolError: if it is not exactly one list, is unbalanced, nested too deeply or too long,
            or has an open quote.
    """
    if len(text) > LENGTH_MAX:
        raise ProtocolError(f"a message of {len(text)} characters is too long")
    outermost: list[Expression] = []
    open_lists = [outermost]
    for match in _TOKEN.finditer(text):
        token = match.group()
        if len(open_lists) == 1 and (outermost or token != "("):
            what = "is followed by something" if outermost else "does not begin with '('"
            raise ProtocolError(f"a message {what}: {excerpt(text)}")
        if token == "(":
            if len(open_lists) > DEPTH_MAX:
                raise ProtocolError(f"a message nests too deeply: {excerpt(text)}")
            inner: list[Expression] = []
            open_lists[-1].append(inner)
            open_lists.append(inner)
        elif token == ")":
            open_lists.pop()
        elif token == '"':
            raise ProtocolError(f"a quote is not closed: {excerpt(text)}")
        elif token[0] == '"':
            open_lists[-1].append(token[1:-1])
        else:
            open_lists[-1].append(token)
    if len(open_lists) > 1:
        raise ProtocolError(f"a parenthesis is not closed: {excerpt(text)}")
    if not outermost:
        raise ProtocolError("an empty message")
    message = outermost[0]
    assert isinstance(message, list)  # it began with a parenthesis
    return message
