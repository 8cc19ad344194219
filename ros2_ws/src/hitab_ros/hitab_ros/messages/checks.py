"""Validation of incoming messages: names, lengths of texts and lists, numbers.

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
from functools import partial
from typing import Any

from rosidl_parser.definition import AbstractNestedType, BasicType, NamespacedType

from hitab_core import CYCLE_MAX, HitabError
from hitab_ros.messages.plain_text import plain

PACKAGE = "hitab_msgs"

ROS_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,99}\Z")
"""Pattern of a part of a topic name, such as the name of an agent, host or world."""

ROS_NAME_RULE = "use up to 100 letters, digits and _, not beginning with a digit"

NAMES = frozenset({"HostRoster.agents", "HostRoster.host"})
"""Fields that become parts of topic names."""

TEXT_MAX = 1000
LONG_TEXT_MAX = 10_000_000
LONG_TEXTS = frozenset({"BehaviorFile.text"})
SEVERAL_LINES = frozenset({"text", "description", "last_error", "faults", "message", "note"})
"""Fields of any message with text for people, which may have several lines."""
PATH_TEXT_MAX = 4096
PATHS = frozenset({"LoadLibrary_Request.path"})

MESSAGE_BYTES_MAX = 12_000_000
"""Maximum size of a message, bytes; fits the largest files and pictures. A list of objects takes a
hundred times the time, and ten times the memory, to become a Python message."""

ITEMS_MAX = 20_000
"""Maximum number of items in a list; the longest are rosters and batches of a host."""
VALUES_MAX = 1_000_000
"""Maximum number of numbers in a list."""

MAY_BE_INFINITE = frozenset({"values", "measures", "position"}) | {
    *("factor", "x", "y", "heading", "vx", "vy", "radius")  # the world reports wrong ones
}
"""Fields of any message with numbers that only a domain can check. A report with a wrong number is
not dropped, since a report is also a heartbeat."""

CYCLES = frozenset({"cycle", "episode_cycle", "seen"})
"""Fields of any message with a world's cycle, which must fit into stored files."""

CLOCK_AHEAD_MAX_S = 3600.0
"""Maximum lead of numbers from another machine's clock over this machine's, s."""
TIMES_OF_DAY = frozenset({"HostRoster.number", "Order.epoch", "Report.epoch"})
"""Fields with numbers from a clock, ns. A number far in the future makes later ones look old."""

Check = Callable[[Any], None]
"""Raises if a message or a value is invalid."""


class BadMessage(HitabError):
    """An invalid message; the text names the field and the expected value."""


def check(message: Any, kind: Any = None) -> None:
    """Check a message or request of the project's own types; any other passes.

    Args:
        message: the message, or an object with its fields.
        kind: type of the message; by default the type of the object.

    Raises:
        BadMessage: if a field is invalid; names the first one.
    """
    checked: Any = kind or type(message)
    for field, one in _checks(checked):
        one(getattr(message, field))


def too_far_ahead(number: int) -> bool:
    """Whether a number from a clock is too far in the future for a clock error."""
    return number > time.time_ns() + int(CLOCK_AHEAD_MAX_S * 1e9)


@functools.cache
def _checks(kind: Any) -> tuple[tuple[str, Check], ...]:
    """Return the checked fields of a type, with their checks."""
    if not kind.__module__.startswith(f"{PACKAGE}."):
        return ()
    fields = zip(kind.get_fields_and_field_types(), kind.SLOT_TYPES, strict=True)
    found = ((field, _check_of(f"{kind.__name__}.{field}", field, slot)) for field, slot in fields)
    return tuple((field, one) for field, one in found if one is not None)


def _check_of(place: str, field: str, slot: Any) -> Check | None:
    """Return the check of a field's values; None without one."""
    if isinstance(slot, AbstractNestedType):
        most = VALUES_MAX if isinstance(slot.value_type, BasicType) else ITEMS_MAX
        return partial(_check_items, place, most, _check_of(place, field, slot.value_type))
    if isinstance(slot, NamespacedType):
        return check if slot.namespaces[0] == PACKAGE else None
    if not isinstance(slot, BasicType):
        limit = LONG_TEXT_MAX if place in LONG_TEXTS else TEXT_MAX
        limit = PATH_TEXT_MAX if place in PATHS else limit
        return partial(_check_text, place, limit, field in SEVERAL_LINES)
    if slot.typename in ("double", "float") and field not in MAY_BE_INFINITE:
        return partial(_check_number, place)
    if field in CYCLES:
        return partial(_check_cycle, place)
    return partial(_check_time_of_day, place) if place in TIMES_OF_DAY else None


def _check_items(place: str, most: int, one: Check | None, values: Sequence[Any]) -> None:
    if len(values) > most:
        raise BadMessage(f"{place} has {len(values)} items; the limit is {most}")
    if one is not None:
        for value in values:
            one(value)


def _check_text(place: str, limit: int, lines: bool, value: str) -> None:
    if len(value) > limit:
        raise BadMessage(f"{place} has {len(value)} characters; the limit is {limit}")
    if place in NAMES and ROS_NAME.match(value) is None:
        raise BadMessage(f"{place}: {_shown(value)} is not a name; {ROS_NAME_RULE}")
    if not (value.isprintable() or (lines and "\0" not in value)):
        raise BadMessage(f"{place}: {_shown(value)} has control characters; remove them")


def _shown(value: str) -> str:
    return plain(f'"{value}"', 80, lines=False)


def _check_number(place: str, value: float) -> None:
    if math.isinf(value):
        raise BadMessage(f"{place} is infinite; give a finite number, or NaN for a missing one")


def _check_cycle(place: str, cycle: int) -> None:
    if cycle > CYCLE_MAX:
        raise BadMessage(f"{place} is {cycle}; no world counts beyond {CYCLE_MAX}")


def _check_time_of_day(place: str, number: int) -> None:
    if too_far_ahead(number):
        raise BadMessage(
            f"{place} is {number} ns, more than {CLOCK_AHEAD_MAX_S / 3600.0:g} h ahead of this "
            "machine's clock; set the clocks of all machines"
        )
