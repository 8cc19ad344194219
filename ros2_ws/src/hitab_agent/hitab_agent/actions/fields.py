"""Action types and the fields of their messages, by name."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import Any

from rosidl_parser.definition import (
    AbstractSequence,
    AbstractString,
    AbstractWString,
    Array,
    BasicType,
    BoundedSequence,
    NamespacedType,
)

from hitab_core import HitabError, unknown

_TYPE = re.compile(r"(\w+)/action/(\w+)\Z")
_BOOLEAN, _REAL = ("boolean",), ("float", "double", "long double")
_BITS = re.compile(r"(u?)int(\d+)\Z")
_TIMES = ("builtin_interfaces/Time", "builtin_interfaces/Duration")


class FieldError(HitabError):
    """A field that a message does not have, or a value that it cannot hold."""


@functools.cache
def action_type(name: str) -> Any:
    """Return the class of an action type such as ``nav2_msgs/action/NavigateToPose``.

    Raises:
        HitabError: if it is not installed.
    """
    match = _TYPE.match(name)
    if match is None:
        raise HitabError(
            f'its type "{name}" is not of the form "package/action/Name", such as '
            '"nav2_msgs/action/NavigateToPose"'
        )
    package, action = match.groups()
    try:
        module = import_module(f"{package}.action")
    except ImportError as error:
        raise HitabError(
            f'its type "{name}" is not installed: {error}; install the package {package}, or '
            "source the workspace that has it, before starting the agent"
        ) from error
    if not hasattr(module, action):
        names = [one for one in vars(module) if one[0].isupper() and "_" not in one]
        raise HitabError(unknown("action", action, names, f" in package {package}"))
    return getattr(module, action)


def put(message: Any, path: str, value: Any) -> None:
    """Set a field of a message.

    Args:
        message: to change.
        path: of the field, such as ``pose.header.frame_id``.
        value: a number, boolean or text; a list; a message, or a mapping with its fields.

    Raises:
        FieldError: naming the field and what it must be.
    """
    *parents, last = path.split(".")
    for parent in parents:
        _slot(message, parent, path)
        message = getattr(message, parent)
    setattr(message, last, _converted(_slot(message, last, path), value, path))


def has_path(kind: Any, path: str) -> Any:
    """Check that messages of a type have a field.

    Returns:
        The type of the field, as its package describes it.

    Raises:
        FieldError: naming what is missing, and what there is.
    """
    message = kind()
    *parents, last = path.split(".")
    for parent in parents:
        _slot(message, parent, path)
        message = getattr(message, parent)
    return _slot(message, last, path)


def is_number(slot: Any) -> bool:
    """Whether a field of this type is a number, a boolean, a duration or a time."""
    if isinstance(slot, NamespacedType):
        return "/".join((slot.namespaces[0], slot.name)) in _TIMES
    return isinstance(slot, BasicType)


def _slot(message: Any, name: str, path: str) -> Any:
    """Return the type of a field of a message.

    Raises:
        FieldError: if there is no such field.
    """
    kind = type(message)
    if not hasattr(kind, "get_fields_and_field_types"):
        raise FieldError(f'"{path}": what is before "{name}" is not a message with fields')
    fields = list(kind.get_fields_and_field_types())
    if name not in fields:
        where = "" if name == path else f' of "{path}" in {kind.__name__}'
        raise FieldError(unknown("field", name, fields, where))
    return kind.SLOT_TYPES[fields.index(name)]


def _converted(slot: Any, value: Any, place: str) -> Any:
    """Return a value as a field of this type holds it.

    rclpy does not check what fields are set to, and a wrong type ends the process when the
    message is sent.

    Raises:
        FieldError: if it is not such a value.
    """
    if isinstance(slot, AbstractString | AbstractWString):
        if not isinstance(value, str):
            raise FieldError(f'"{place}" must be text, not {value!r}')
        return value
    if isinstance(slot, AbstractSequence | Array):
        return _list(slot, value, place)
    if isinstance(slot, NamespacedType):
        return _message(slot, value, place)
    return _basic(slot.typename, value, place)


def _list(slot: Any, value: Any, place: str) -> list[Any]:
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise FieldError(f'"{place}" must be a list, not {value!r}')
    items = [_converted(slot.value_type, one, f"{place}[{i}]") for i, one in enumerate(value)]
    if isinstance(slot, Array) and len(items) != slot.size:
        raise FieldError(f'"{place}" must have {slot.size} items, not {len(items)}')
    if isinstance(slot, BoundedSequence) and len(items) > slot.maximum_size:
        raise FieldError(f'"{place}" can have {slot.maximum_size} items, not {len(items)}')
    return items


def _message(slot: NamespacedType, value: Any, place: str) -> Any:
    kind = getattr(import_module(".".join(slot.namespaces)), slot.name)
    if isinstance(value, kind):
        return value
    if not isinstance(value, Mapping):
        raise FieldError(
            f'"{place}" must be a {"/".join((slot.namespaces[0], slot.name))}, or a mapping with '
            f"its fields, not {value!r}"
        )
    message = kind()
    for name, part in value.items():
        try:
            put(message, name, part)
        except FieldError as error:
            raise FieldError(f'in "{place}": {error}') from None
    return message


def _basic(typename: str, value: Any, place: str) -> Any:
    wrong = FieldError(f'"{place}" must be a number of type {typename}, not {value!r}')
    if typename in _BOOLEAN:
        if value not in (True, False):
            raise FieldError(f'"{place}" must be true or false, not {value!r}')
        return bool(value)
    if typename == "octet":
        if not isinstance(value, bytes) or len(value) != 1:
            raise wrong
        return value
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise wrong from None
    if isinstance(value, str) or math.isnan(number):
        raise wrong
    if typename in _REAL:
        return number
    bits = _BITS.match(typename)
    if bits is None or number != number // 1 or math.isinf(number):
        raise wrong
    signed, size = not bits[1], int(bits[2])
    low, high = (-(2 ** (size - 1)), 2 ** (size - 1)) if signed else (0, 2**size)
    whole = int(value)
    if not low <= whole < high:
        raise wrong
    return whole
