"""The definitions of messages with all their parts, as recordings contain them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory

_FIELD = re.compile(r"^\s*([A-Za-z][\w/]*)(?:\[[^\]]*\]|<=\d+)*\s+[A-Za-z]\w*")
_BREAK = "=" * 80


def type_name(kind: Any) -> str:
    """Return the name of a message's type, such as ``hitab_msgs/msg/WorldState``."""
    return "/".join((kind.__module__.split(".")[0], "msg", kind.__name__))


@cache
def definition(name: str) -> str:
    """Return the definition of a type, followed by those of its parts."""
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
    package, _, kind = name.split("/")
    return Path(get_package_share_directory(package), "msg", f"{kind}.msg").read_text("utf-8")


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
