"""Reads messages of rcssserver, protocol version 15, into `keepaway_world.rcss.messages`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from keepaway_world.rcss.messages import (
    LEFT,
    REFEREE,
    RIGHT,
    SELF,
    FullState,
    Hear,
    Init,
    Message,
    Ok,
    Other,
    Parameters,
    PlayerState,
    Refusal,
    See,
    SeenObject,
    SenseBody,
    Think,
    number_of,
)
from keepaway_world.rcss.sexpr import Expression, ProtocolError, excerpt, parse


def parse_message(text: str) -> Message:
    """Return a message of the server as data.

    Raises:
        ProtocolError: if it is not one, or lacks a part.
    """
    expression = parse(text)
    if not expression or not isinstance(expression[0], str):
        raise ProtocolError(f"a message without a name: {excerpt(text)}")
    kind = expression[0]
    read = _READERS.get(kind)
    if read is None:
        return Other(kind, expression[1:])
    try:
        return read(kind, expression)
    except (IndexError, TypeError, ValueError) as error:
        why = str(error) if isinstance(error, ProtocolError) else "a part is missing"
        raise ProtocolError(
            f"not a {kind} message of protocol version 15 ({why}): {excerpt(text)}"
        ) from None


def _whole(atom: Expression) -> int:
    value = number_of(atom)
    if value != int(value):
        raise ProtocolError(f"{atom} is not a whole number")
    return int(value)


def _text(atom: Expression) -> str:
    if not isinstance(atom, str):
        raise ProtocolError("a list where a word should be")
    return atom


def _list(expression: Expression) -> list[Expression]:
    if not isinstance(expression, list):
        raise ProtocolError(f"{excerpt(expression)} where a list should be")
    return expression


def _named(parts: Sequence[Expression]) -> dict[str, list[Expression]]:
    """Return the lists among ``parts`` by their first word."""
    found = {}
    for part in parts:
        if isinstance(part, list) and part and isinstance(part[0], str):
            found[part[0]] = part
    return found


def _wanted(found: Mapping[str, list[Expression]], name: str) -> list[Expression]:
    if name not in found:
        raise ProtocolError(f"no {name}")
    return found[name]


def _init(kind: str, e: list[Expression]) -> Message:
    if len(e) == 2 and e[1] == "ok":
        return Init("", 0, "")
    side = _text(e[1])
    if side not in (LEFT, RIGHT):
        raise ProtocolError(f"no side {excerpt(side)}")
    return Init(side, _whole(e[2]), _text(e[3]))


def _refusal(kind: str, e: list[Expression]) -> Message:
    return Refusal(kind, " ".join(part for part in e[1:] if isinstance(part, str)))


def _parameters(kind: str, e: list[Expression]) -> Message:
    values = {}
    for part in e[1:]:
        pair = _list(part)
        values[_text(pair[0])] = _text(pair[1])
    return Parameters(kind, values)


def _sense_body(kind: str, e: list[Expression]) -> Message:
    found = _named(e[2:])
    speed = _wanted(found, "speed")
    head = _wanted(found, "head_angle")
    kick = _wanted(found, "kick")
    return SenseBody(
        _whole(e[1]), number_of(speed[1]), number_of(speed[2]), number_of(head[1]), _whole(kick[1])
    )


def _full_state(kind: str, e: list[Expression]) -> Message:
    mode = _text(_wanted(_named(e[2:]), "pmode")[1])
    ball: tuple[float, float, float, float] | None = None
    players = []
    for part in e[2:]:
        thing = _list(part)
        if not isinstance(thing[0], list):
            continue
        name = thing[0]
        if name[0] == "b":
            x, y, vx, vy = (number_of(value) for value in thing[1:5])
            ball = x, y, vx, vy
        elif name[0] == "p":
            players.append(_player(name, thing))
    if ball is None:
        raise ProtocolError("no ball")
    return FullState(_whole(e[1]), mode, ball, tuple(players))


def _player(name: list[Expression], thing: list[Expression]) -> PlayerState:
    side = _text(name[1])
    if side not in (LEFT, RIGHT):
        raise ProtocolError(f"no side {excerpt(side)}")
    x, y, vx, vy, body = (number_of(value) for value in thing[1:6])
    return PlayerState(side, _whole(name[2]), x, y, vx, vy, body, "k" in thing[6:])


def _see(kind: str, e: list[Expression]) -> Message:
    objects = []
    for part in e[2:]:
        thing = _list(part)
        name = tuple(_text(word) for word in _list(thing[0]))
        if not name:
            raise ProtocolError("something without a name is seen")
        figures = [number_of(value) for value in thing[1:] if value not in ("k", "t", "f")]
        if len(figures) == 1:
            objects.append(SeenObject(name, math.nan, figures[0]))
        else:
            change = figures[2:4] if len(figures) >= 4 else [math.nan, math.nan]
            objects.append(SeenObject(name, figures[0], figures[1], *change))
    return See(_whole(e[1]), tuple(objects))


def _hear(kind: str, e: list[Expression]) -> Message:
    time, sender = _whole(e[1]), _text(e[2])
    if sender in (REFEREE, SELF) or "coach" in sender:
        return Hear(time, sender, " ".join(_text(word) for word in e[3:]))
    number_of(sender)  # the direction in which an ordinary player was heard
    team = _text(e[3])
    number = _whole(e[4]) if len(e) > 5 else 0
    return Hear(time, sender, _text(e[-1]), team, number)


def _think(kind: str, e: list[Expression]) -> Message:
    return Think()


def _ok(kind: str, e: list[Expression]) -> Message:
    return Ok(_text(e[1]))


_READERS: Mapping[str, Callable[[str, list[Expression]], Message]] = {
    "init": _init,
    "error": _refusal,
    "warning": _refusal,
    "server_param": _parameters,
    "player_param": _parameters,
    "player_type": _parameters,
    "sense_body": _sense_body,
    "fullstate": _full_state,
    "see": _see,
    "hear": _hear,
    "think": _think,
    "ok": _ok,
}
