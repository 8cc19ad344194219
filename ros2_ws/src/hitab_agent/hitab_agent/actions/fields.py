"""Action types and the fields of their messages, by name."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import Any

from rosidl_parser.definition import (
    AbstractNestedType,
    BasicType,
    NamespacedType,
)

from hitab_core import HitabError, unknown

_TYPE = re.compile(r"(\w+)/action/(\w+)\Z")
_REAL = ("float", "double", "long double")
_TIMES = (["builtin_interfaces", "msg", "Time"], ["builtin_interfaces", "msg", "Duration"])


class FieldError(HitabError):
    """A field that is missing in a message, or a value that does not fit the field."""


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
        message: the message to change.
        path: path of the field, such as ``pose.header.frame_id``.
        value: a number, boolean or text; a list; a message, or a mapping with its fields.

    Raises:
        FieldError: naming the field and its type.
    """
    parent, name, slot = _found(message, path)
    try:
        converted = _converted(slot, value)
        # By default a message does not check the values of its fields, and publishing one with a
        # wrong type ends the process.
        setattr(type(parent)(check_fields=True), name, converted)
    except (AssertionError, TypeError, ValueError, OverflowError) as error:
        raise FieldError(f'"{path}" cannot be {value!r}: {error}') from None
    setattr(parent, name, converted)


def slot_of(kind: Any, path: str) -> Any:
    """Return the type of a field, as the package of the message describes it.

    Raises:
        FieldError: naming the missing field, and the fields that exist.
    """
    return _found(kind(), path)[2]


def is_number(slot: Any) -> bool:
    """Whether a field of this type is a number, a boolean, a duration or a time."""
    if isinstance(slot, NamespacedType):
        return [*slot.namespaces, slot.name] in _TIMES
    return isinstance(slot, BasicType)


def _found(message: Any, path: str) -> tuple[Any, str, Any]:
    """Return the message with the field that a path leads to, and the field's name and type."""
    *parents, last = path.split(".")
    for name in (*parents, last):
        if not hasattr(message, "SLOT_TYPES"):
            raise FieldError(f'"{path}": what is before "{name}" is not a message with fields')
        fields = list(message.get_fields_and_field_types())
        if name not in fields:
            where = "" if name == path else f' of "{path}" in {type(message).__name__}'
            raise FieldError(unknown("field", name, fields, where))
        parent, slot = message, message.SLOT_TYPES[fields.index(name)]
        message = getattr(message, name)
    return parent, last, slot


def _converted(slot: Any, value: Any) -> Any:
    """Return a value converted to the type of a field; unsuitable values stay as they are."""
    if isinstance(slot, AbstractNestedType):
        if isinstance(value, str) or not isinstance(value, Iterable):
            raise TypeError("it must be a list")
        return [_converted(slot.value_type, one) for one in value]
    if isinstance(slot, NamespacedType) and isinstance(value, Mapping):
        message = getattr(import_module(".".join(slot.namespaces)), slot.name)()
        for name, part in value.items():
            put(message, name, part)
        return message
    if not isinstance(slot, BasicType) or isinstance(value, str | bytes):
        return value
    if slot.typename == "boolean":
        return bool(value) if value in (True, False) else value
    number = float(value) if slot.typename in _REAL else int(value)
    if number != value:  # NaN is no number either
        raise ValueError("it must be a number, and a whole one if the field holds integers")
    return number
