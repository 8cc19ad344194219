"""The definitions of messages with all their parts, as recordings contain them."""

from __future__ import annotations

import re
from functools import cache
from importlib import import_module
from typing import Any

from hitab_client.errors import SwarmError
from hitab_ros import share_folder

_FIELD = re.compile(r"^\s*([A-Za-z][\w/]*)(?:\[[^\]]*\]|<=\d+)*\s+[A-Za-z]\w*")
_BREAK = "=" * 80


def type_name(kind: Any) -> str:
    """Return the name of a message's type, such as ``hitab_msgs/msg/WorldState``."""
    package, folder = kind.__module__.split(".")[:2]
    return "/".join((package, folder, kind.__name__))


def message_class(name: str) -> Any:
    """Return the class of a type, such as ``sensor_msgs/msg/LaserScan``.

    Raises:
        SwarmError: if it is not installed here.
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
    """Return the definition of a type, followed by those of its parts.

    Raises:
        SwarmError: if its package has none.
    """
    own = _text(name)
    parts = [own]
    waiting, seen = _inner(name, own), {name}
    while waiting:
        inner = waiting.pop(0)
        if inner in seen:
            continue
        seen.add(inner)
        text = _text(inner)
        package, _, kind = inner.split("/")
        parts.append(f"{_BREAK}\nMSG: {package}/{kind}\n{text}")
        waiting += _inner(inner, text)
    return "\n".join(parts)


def _text(name: str) -> str:
    package, folder, kind = name.split("/")
    return _file(package, folder, f"{kind}.msg")


def _file(package: str, folder: str, file: str) -> str:
    try:
        return (share_folder(package) / folder / file).read_text("utf-8")
    except (LookupError, OSError):
        raise SwarmError(
            f"the ROS package {package} has no {folder}/{file} here, which a recording must "
            "contain; install that package"
        ) from None


def _inner(name: str, text: str) -> list[str]:
    package = name.split("/")[0]
    found = []
    for line in text.splitlines():
        match = _FIELD.match(line)
        if match is None or not match.group(1).split("/")[-1][0].isupper():
            continue
        parts = match.group(1).split("/")
        found.append(f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}")
    return found
