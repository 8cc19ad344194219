"""Validates incoming messages: names, lengths of texts and lists, numbers.

Every message and request of the project's own types is checked before any callback sees it, so
that callbacks need no checks of their own. The rules follow from the types of the fields, with
exceptions in the tables below, so new messages are checked as well.
"""

from __future__ import annotations

import functools
import math
import re
import time
from collections.abc import Callable, Sequence
from typing import Any

from rosidl_parser.definition import AbstractSequence, Array, NamespacedType

from hitab_core import HitabError
from hitab_ros.plain_text import plain

PACKAGE = "hitab_msgs"

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,99}\Z")
"""Pattern of a part of a topic name, such as the name of an agent, host or world."""

NAME_RULE = "use up to 100 letters, digits and _, not beginning with a digit"

NAMES = frozenset({"HostRoster.agents", "HostRoster.host"})
"""Fields that become parts of topic names."""

TEXT_MAX = 1000
LONG_TEXT_MAX = 10_000_000
LONG_TEXTS = frozenset({"BehaviorFile.text"})
SEVERAL_LINES = frozenset({"text", "description", "last_error", "faults", "message", "note"})
"""Fields of any message with text for people, which may have several lines."""
PATH_TEXT_MAX = 4096
PATHS = frozenset({"LoadLibrary_Request.path"})

BYTES_MAX = 12_000_000
"""Maximum size of a message. A list of objects takes a hundred times its time, and ten times its
memory, to become a message of Python's; the largest files and pictures that are sent fit."""

ITEMS_MAX = 20_000
"""Maximum items of a list; the largest are the rosters and batches of a host."""
VALUES_MAX = 1_000_000
"""Maximum numbers in a list."""

MAY_BE_INFINITE = frozenset({"values", "measures", "position"}) | {
    *("factor", "x", "y", "heading", "vx", "vy", "radius")  # the world reports what is wrong
}
"""Fields of any message with numbers that only a domain can check. A report is also a heartbeat,
so it is not dropped because of them."""

AHEAD_S = 3600.0
"""How far numbers made from the time of day may be ahead of this machine's clock."""
TIMES_OF_DAY = frozenset({"HostRoster.number", "Order.epoch", "Report.epoch"})
"""Such numbers, ns. One from the far future would make all later ones look old."""

Check = Callable[[Any], None]


class BadMessage(HitabError):
    """An invalid message; the text names the field and the expected value."""


def check(message: Any) -> None:
    """Check a message or request of the project's own types; any other passes.

    Raises:
        BadMessage: naming the first field that is wrong.
    """
    kind: Any = type(message)
    for one in _checks(kind):
        one(message)


def too_far_ahead(number: int) -> bool:
    """Whether a number made from the time of day is too far in the future for a clock error."""
    return number > time.time_ns() + int(AHEAD_S * 1e9)


@functools.cache
def _checks(kind: Any) -> tuple[Check, ...]:
    if not kind.__module__.startswith(f"{PACKAGE}."):
        return ()
    found = []
    fields = kind.get_fields_and_field_types()
    for field, slot in zip(fields, kind.SLOT_TYPES, strict=True):
        one = _check_of(kind.__name__, field, slot)
        if one is not None:
            found.append(one)
    return tuple(found)


def _check_of(message: str, field: str, slot: Any) -> Check | None:
    """Return the check of one field; None if it needs none."""
    place = f"{message}.{field}"
    many = isinstance(slot, AbstractSequence | Array)
    item = slot.value_type if many else slot
    if isinstance(item, NamespacedType):
        if item.namespaces[0] != PACKAGE:
            return None
        return _nested(place, field, many)
    kind = getattr(item, "typename", "string")
    if kind == "string" or not hasattr(item, "typename"):
        text = _text_check(place)
        return _texts(place, field, text) if many else lambda m: text(getattr(m, field))
    if many:
        return _numbers(place, field, kind)
    if kind in ("double", "float"):
        return None if field in MAY_BE_INFINITE else _number(place, field)
    if place in TIMES_OF_DAY:
        return _time_of_day(place, field)
    return None


def _nested(place: str, field: str, many: bool) -> Check:
    def nested(message: Any) -> None:
        items: Sequence[Any] = getattr(message, field)
        _check_count(place, items, ITEMS_MAX)
        for item in items:
            check(item)

    def one(message: Any) -> None:
        check(getattr(message, field))

    return nested if many else one


def _text_check(place: str) -> Callable[[str], None]:
    limit = LONG_TEXT_MAX if place in LONG_TEXTS else TEXT_MAX
    limit = PATH_TEXT_MAX if place in PATHS else limit
    lines, named = place.partition(".")[2] in SEVERAL_LINES, place in NAMES

    def text(value: str) -> None:
        if len(value) > limit:
            raise BadMessage(f"{place} has {len(value)} characters; the limit is {limit}")
        if named and NAME.match(value) is None:
            raise BadMessage(f"{place}: {_shown(value)} is not a name; {NAME_RULE}")
        if not (value.isprintable() or (lines and "\0" not in value)):
            raise BadMessage(f"{place}: {_shown(value)} has control characters; remove them")

    return text


def _shown(value: str) -> str:
    return plain(f'"{value}"', 80, lines=False)


def _texts(place: str, field: str, text: Callable[[str], None]) -> Check:
    def texts(message: Any) -> None:
        values: Sequence[str] = getattr(message, field)
        if values:
            _check_count(place, values, ITEMS_MAX)
            for value in values:
                text(value)

    return texts


def _numbers(place: str, field: str, kind: str) -> Check:
    real = kind in ("double", "float") and field not in MAY_BE_INFINITE

    def numbers(message: Any) -> None:
        values = getattr(message, field)
        _check_count(place, values, VALUES_MAX)
        if real and any(map(math.isinf, values)):
            raise BadMessage(f"{place} has an infinite number; NaN stands for a missing one")

    return numbers


def _number(place: str, field: str) -> Check:
    def number(message: Any) -> None:
        if math.isinf(getattr(message, field)):
            raise BadMessage(f"{place} is infinite; give a finite number")

    return number


def _time_of_day(place: str, field: str) -> Check:
    def time_of_day(message: Any) -> None:
        number = getattr(message, field)
        if too_far_ahead(number):
            raise BadMessage(
                f"{place} is {number} ns, more than {AHEAD_S / 3600.0:g} h ahead of this "
                "machine's clock; set the clocks of all machines"
            )

    return time_of_day


def _check_count(place: str, items: Sequence[Any], most: int) -> None:
    if len(items) > most:
        raise BadMessage(f"{place} has {len(items)} items; the limit is {most}")
