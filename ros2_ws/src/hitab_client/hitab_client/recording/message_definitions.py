"""Definitions of messages with all their parts, as recordings contain them."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from mcap.records import Schema

from hitab_client.errors import SwarmError
from hitab_ros import own_hashes, share_folder

_BREAK = "=" * 80


def type_name(kind: Any) -> str:
    """Return the name of a message's type, such as ``hitab_msgs/msg/WorldState``."""
    package, folder = kind.__module__.split(".")[:2]
    return "/".join((package, folder, kind.__name__))


def message_class(name: str) -> Any:
    """Return the class of a type, such as ``sensor_msgs/msg/LaserScan``.

    Raises:
        SwarmError: if the type is not installed here.
    """
    package, _, rest = name.partition("/")
    folder, _, kind = rest.partition("/")
    try:
        module = import_module(f"{package}.{folder}")
        return getattr(module, kind)
    except (ImportError, AttributeError, ValueError):
        raise SwarmError(
            f"messages of type {name} cannot be read here: install the ROS package {package}, or "
            "source the workspace that has it"
        ) from None


@cache
def definition(name: str) -> str:
    """Return the definition of a type, followed by the definitions of its parts.

    Raises:
        SwarmError: if the type's package has no such definition.
    """
    parts = [_text(name)]
    for inner in own_hashes(name):
        if inner != name:
            package, _, kind = inner.split("/")
            parts.append(f"{_BREAK}\nMSG: {package}/{kind}\n{_text(inner)}")
    return "\n".join(parts)


def same_definition(schema: Schema) -> bool:
    """Return whether a recorded definition equals the installed one, apart from comments.

    Other releases of ROS 2 have other comments, and list the parts in another order.
    """
    return _meaning(schema.data.decode(errors="replace")) == _meaning(definition(schema.name))


def _meaning(text: str) -> tuple[list[str], ...]:
    first, *parts = text.split(_BREAK)
    return tuple(
        [stripped for line in part.splitlines() if (stripped := line.partition("#")[0].strip())]
        for part in (first, *sorted(parts))
    )


def _text(name: str) -> str:
    package, folder, kind = name.split("/")
    try:
        return (share_folder(package) / folder / f"{kind}.msg").read_text("utf-8")
    except (LookupError, OSError):
        raise SwarmError(
            f"the ROS package {package} has no {folder}/{kind}.msg here, which a recording must "
            "contain; install that package"
        ) from None
