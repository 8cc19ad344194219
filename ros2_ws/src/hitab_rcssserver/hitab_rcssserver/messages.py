"""The messages of rcssserver as data, and its commands as text; protocol version 15.

All values are in the server's units and axes: y points down, angles are in degrees, clockwise,
speeds are per cycle. `hitab_rcssserver.field` converts them to HiTAB's.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from keepaway_world.action import Order

LEFT, RIGHT = "l", "r"
REFEREE, SELF, OUR = "referee", "self", "our"
BEFORE_KICK_OFF, PLAYING = "before_kick_off", "play_on"
EPISODE_OVER = "training Keepaway 1"
"""The referee's message when an episode has ended and the next one has been set up."""

Expression: TypeAlias = "str | list[Expression]"
"""An atom or a list. Numbers stay text; quoted texts lose their quotes."""

_TOKEN = re.compile(r'[()]|"[^"]*"|[^\s()"]+|"')


class ProtocolError(ValueError):
    """A message that is not of rcssserver; the text describes the error."""


@dataclass(frozen=True, slots=True)
class Init:
    """The answer to ``(init ...)``; ``side`` is "" and ``number`` 0 for a trainer."""

    side: str = ""
    number: int = 0
    mode: str = ""


@dataclass(frozen=True, slots=True)
class Refusal:
    """An ``(error ...)``."""

    reason: str


@dataclass(frozen=True, slots=True)
class Settings:
    """The ``server_param``, by name."""

    values: Mapping[str, str]

    def number(self, name: str, otherwise: float) -> float:
        """Return a numeric setting, or ``otherwise`` if the server has none.

        Raises:
            ProtocolError: if it is not a number.
        """
        return _number(self.values[name]) if name in self.values else otherwise


@dataclass(frozen=True, slots=True)
class SenseBody:
    """A player's own state: its speed and its direction, its neck, its kicks so far."""

    time: int
    speed: float
    speed_direction: float
    head_angle: float
    kicks: int


@dataclass(frozen=True, slots=True)
class PlayerState:
    """One player in a `FullState`; ``kicked``: it tried to kick in this cycle."""

    side: str
    number: int
    x: float
    y: float
    vx: float
    vy: float
    body: float
    kicked: bool = False
    goalie: bool = False


@dataclass(frozen=True, slots=True)
class FullState:
    """The true state of everything."""

    time: int
    mode: str
    ball: tuple[float, float, float, float]
    players: tuple[PlayerState, ...]


@dataclass(frozen=True, slots=True)
class SeenObject:
    """A seen object, with its name in parts, such as ``("p", "takers", "2")``.

    Unknown values are NaN, such as the distance of a line whose end alone is seen.
    """

    name: tuple[str, ...]
    distance: float
    direction: float
    distance_change: float = math.nan
    direction_change: float = math.nan


@dataclass(frozen=True, slots=True)
class See:
    """The things in a player's sight, relative to its neck."""

    time: int
    objects: tuple[SeenObject, ...]


@dataclass(frozen=True, slots=True)
class Hear:
    """Something said: by `REFEREE`, by `SELF`, or by a player of ``team`` "our" or "opp"."""

    time: int
    sender: str
    text: str
    team: str = ""


@dataclass(frozen=True, slots=True)
class Think:
    """In synch mode: the server waits for this client's commands and ``(done)``."""


@dataclass(frozen=True, slots=True)
class Ok:
    """A trainer's command was carried out."""

    command: str


Message: TypeAlias = Init | Refusal | Settings | SenseBody | FullState | See | Hear | Think | Ok


# -- reading --------------------------------------------------------------------------------------


def decode(datagram: bytes) -> str:
    """Return the text of a datagram without its trailing NULs and line ends.

    Raises:
        ProtocolError: if it is not ASCII.
    """
    try:
        return datagram.rstrip(b"\0\r\n").decode("ascii")
    except UnicodeDecodeError:
        shown = _excerpt(datagram.decode("latin-1"))
        raise ProtocolError(f"not a message of rcssserver, which speaks ASCII: {shown}") from None


def parse_message(text: str) -> Message | None:
    """Return a message of the server as data; None if its kind is not used here.

    Raises:
        ProtocolError: if the text is no message, or lacks a part.
    """
    kind, *parts = parse(text) or [""]
    if not isinstance(kind, str) or not kind:
        raise ProtocolError(f"a message without a name: {_excerpt(text)}")
    if kind not in _READERS:
        return None
    try:
        return _READERS[kind](*parts)
    except (LookupError, TypeError, ValueError) as error:
        raise ProtocolError(
            f"not a {kind} message of protocol version 15 ({error}): {_excerpt(text)}"
        ) from None


def parse(text: str) -> list[Expression]:
    """Return a message, an S-expression such as ``(hear 41 1 our 3 "p1")``, as a list.

    Raises:
        ProtocolError: if the text is not exactly one list, is unbalanced, or has an open quote.
    """
    outermost: list[Expression] = []
    open_lists = [outermost]
    for match in _TOKEN.finditer(text):
        token = match.group()
        if len(open_lists) == 1 and (outermost or token != "("):
            what = "is followed by something" if outermost else "does not begin with '('"
            raise ProtocolError(f"a message {what}: {_excerpt(text)}")
        if token == "(":
            inner: list[Expression] = []
            open_lists[-1].append(inner)
            open_lists.append(inner)
        elif token == ")":
            open_lists.pop()
        elif token == '"':
            raise ProtocolError(f"a quote is not closed: {_excerpt(text)}")
        else:
            open_lists[-1].append(token[1:-1] if token[0] == '"' else token)
    if len(open_lists) > 1 or not outermost:
        raise ProtocolError(f"a message is not closed, or empty: {_excerpt(text)}")
    message = outermost[0]
    assert isinstance(message, list)  # it began with a parenthesis
    return message


def _excerpt(text: str, length: int = 60) -> str:
    """Return the printable beginning of a message, for an error's text."""
    return repr(text if len(text) <= length else text[: length - 3] + "...")


def _number(atom: Any) -> float:
    word = _word(atom)
    try:
        value = float(word)
    except ValueError:
        raise ProtocolError(f"{_excerpt(word)} is not a number") from None
    if not math.isfinite(value):
        raise ProtocolError(f"{value} is not finite")
    return value


def _whole(atom: Any) -> int:
    value = _number(atom)
    if not value.is_integer():
        raise ProtocolError(f"{value} is not a whole number")
    return int(value)


def _word(atom: Any) -> str:
    if not isinstance(atom, str):
        raise ProtocolError("a list where a word should be")
    return atom


def _list(part: Any) -> list[Any]:
    if not isinstance(part, list):
        raise ProtocolError(f"{part} where a list should be")
    return part


def _side(atom: Any) -> str:
    if atom not in (LEFT, RIGHT):
        raise ProtocolError("no such side")
    return str(atom)


def _init(*e: Any) -> Init:
    return Init() if e == ("ok",) else Init(_side(e[0]), _whole(e[1]), _word(e[2]))


def _settings(*e: Any) -> Settings:
    return Settings({_word(name): _word(value) for name, value, *_ in map(_list, e)})


def _sense_body(time: Any, *e: Any) -> SenseBody:
    parts = {_word(name): values for name, *values in map(_list, e)}
    speed, neck, kicks = parts["speed"], parts["head_angle"], parts["kick"]
    forward, direction, turned = map(_number, (*speed[:2], neck[0]))
    return SenseBody(_whole(time), forward, direction, turned, _whole(kicks[0]))


def _full_state(time: Any, *e: Any) -> FullState:
    mode, ball, players = "", None, []
    for part in e:
        match part:
            case ["pmode", str(name)]:
                mode = name
            case [["b"], x, y, vx, vy, *_]:
                ball = (_number(x), _number(y), _number(vx), _number(vy))
            case [["p", side, number, *sort], x, y, vx, vy, body, *rest]:
                x, y, vx, vy, body = map(_number, (x, y, vx, vy, body))
                who, marks = (_side(side), _whole(number)), ("k" in rest, "g" in sort)
                players.append(PlayerState(*who, x, y, vx, vy, body, *marks))
            case [["b" | "p", *_], *_]:
                raise ProtocolError("a part is missing")
    if ball is None or not mode:
        raise ProtocolError("no ball or mode of play")
    return FullState(_whole(time), mode, ball, tuple(players))


def _see(time: Any, *e: Any) -> See:
    objects = []
    for name, *values in map(_list, e):
        figures = [_number(value) for value in values if value not in ("k", "t", "f")]
        if len(figures) == 1:
            figures.insert(0, math.nan)
        used = figures[: 4 if len(figures) >= 4 else 2]
        objects.append(SeenObject(tuple(map(_word, _list(name))), *used))
    return See(_whole(time), tuple(objects))


def _hear(time: Any, sender: Any, *e: Any) -> Hear:
    if sender in (REFEREE, SELF) or "coach" in sender:
        return Hear(_whole(time), sender, " ".join(map(_word, e)))
    _number(sender)  # the direction in which an ordinary player was heard
    return Hear(_whole(time), sender, _word(e[-1]), _word(e[0]))


_READERS: Mapping[str, Callable[..., Message]] = {
    "init": _init,
    "error": lambda *e: Refusal(" ".join(map(_word, e))),
    "server_param": _settings,
    "sense_body": _sense_body,
    "fullstate": _full_state,
    "see": _see,
    "hear": _hear,
    "think": lambda: Think(),
    "ok": lambda *e: Ok(_word(e[0])),
}


# -- commands -------------------------------------------------------------------------------------

_SAYABLE = re.compile(r"[0-9A-Za-z().+*/?<>_ -]+")
"""Pattern of the messages that the server accepts."""


def command_of(order: Order) -> tuple[str, ...]:
    """Return the server's command for an order, if any: radians to degrees, y up to y down."""
    kind, amount, direction = order
    if kind == "dash":
        return (f"(dash {_within(amount, -100.0, 100.0):.4f})",)
    if kind == "turn":
        return (f"(turn {_degrees(amount):.4f})",)
    if kind == "catch":
        return (f"(catch {_degrees(amount):.4f})",)
    if kind == "kick":
        return (f"(kick {_within(amount, 0.0, 100.0):.4f} {_degrees(direction):.4f})",)
    return ()


def say(message: str) -> str:
    """Return the command to say something.

    Raises:
        ValueError: if the server would not transmit it.
    """
    if not _SAYABLE.fullmatch(message):
        raise ValueError(
            f"cannot say {message!r}: on an rcssserver a message is made of letters, digits, "
            "spaces and ( ) . + - * / ? < > _; it is not heard"
        )
    return f'(say "{message}")'


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _degrees(angle: float) -> float:
    return -math.degrees(_within(angle, -math.pi, math.pi))
