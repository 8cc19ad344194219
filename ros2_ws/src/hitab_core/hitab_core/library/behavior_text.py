"""Writes a behavior file for people to read, one line per item."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import yaml

from hitab_core.library.yaml_places import means_itself

Rules = Mapping[str, Sequence[object]]
"""Learned rules of each state, whose texts are written as comments."""

_RIGHT = ("number", "features", "command", "cycle", "ago", "values")
"""Keys whose values are aligned to the right."""

_APART = {
    *("states", "features", "examples", "trees", "uses", "readable", "provenance", "optional")
}
"""Keys with an empty line above."""

_COMMENTS = {
    "features": "  # in the order of the examples' values",
    "examples": "  # in state, seeing these features, go to next_state",
    "trees": "  # digests of what is learned from the examples of each state",
    "uses": "  # what it is made of, as it was when this was saved",
    "readable": "  # what could be read when the commands were given",
    "readings": "  # in that order; null: it had no value",
}
"""Behind keys."""

_WORD = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.()-]*\Z", re.ASCII)


def behavior_text(content: Mapping[str, Any], rules: Rules) -> str:
    """Return the text of a behavior file.

    Args:
        content: the content, as in `hitab_core.library.behavior_model.BehaviorRecord`.
        rules: readable rules by state.
    """
    lines = [
        "# A behavior trained by demonstration. It may be edited: then it is what it says, and",
        "# `hitab library check` says that it was edited.",
    ]
    for key, value in content.items():
        if key in _APART:
            lines.append("")
        lines.extend(_section(key, value, rules, content))
    return "\n".join(lines) + "\n"


def _section(key: str, value: Any, rules: Rules, content: Mapping[str, Any]) -> Iterable[str]:
    match key:
        case "states" | "readable":
            lines = [f"- {scalar(term)}" for term in value]
        case "features":
            lines = [f"- {_flow(feature)}" for feature in value]
        case "examples":
            names = ", ".join(feature["feature"] for feature in content["features"])
            lines = [f"# features: {names}", *_table(value)] if value else []
        case "trees":
            lines = _trees(value, rules)
        case "uses" | "provenance":
            lines = [f"{name}: {scalar(what)}" for name, what in value.items()]
        case "readings":
            lines = list(_table(value)) if value else []
        case "optional":
            lines = []
            for name, records in value.items():
                rows = records if isinstance(records, list) else []
                lines += _block(f"{name}:", [f"- {_flow(row)}" for row in rows], _flow(records))
        case _:
            return [f"{key}: {_flow(value)}"]
    empty = "{}" if isinstance(value, Mapping) else "[]"
    return _block(f"{key}:{_COMMENTS.get(key, '')}", lines, empty)


def _block(head: str, lines: Sequence[str], empty: str) -> list[str]:
    if not lines:
        key, _, comment = head.partition(":")
        return [f"{key}: {empty}{comment}"]
    return [head, *(f"  {line}" for line in lines)]


def _trees(digests: Mapping[str, str], rules: Rules) -> list[str]:
    lines = []
    for state, digest in digests.items():
        # A line break in a name must not end the comment.
        lines += [f"# {' '.join(str(rule).split())}" for rule in rules.get(state, ())]
        lines.append(f"{scalar(state)}: {scalar(digest)}")
    return lines


def _table(examples: Sequence[Mapping[str, Any]]) -> Iterable[str]:
    """Return one line per example, with aligned columns."""
    rows = [
        [
            [scalar(value) for value in cell] if isinstance(cell, list) else [scalar(cell)]
            for cell in example.values()
        ]
        for example in examples
    ]
    keys = list(examples[0])
    width = [
        [max(map(len, column)) for column in zip(*(row[k] for row in rows), strict=True)]
        for k in range(len(keys))
    ]
    for row, example in zip(rows, examples, strict=True):
        cells = []
        for k, key in enumerate(keys):
            parts = [
                part.rjust(w) if key in _RIGHT else part
                for part, w in zip(row[k], width[k], strict=True)
            ]
            text = f"[{', '.join(parts)}]" if isinstance(example[key], list) else parts[0]
            comma = "," if k + 1 < len(keys) else ""
            pad = max(width[k]) + 1 if key in ("state", "next_state", "kind") else 0
            cells.append(f"{key}: " + f"{text}{comma}".ljust(pad))
        yield f"- {{{' '.join(cells)}}}"


def _flow(value: Any) -> str:
    if isinstance(value, Mapping):
        return (
            "{" + ", ".join(f"{scalar(key)}: {_flow(inner)}" for key, inner in value.items()) + "}"
        )
    if isinstance(value, list):
        return "[" + ", ".join(_flow(inner) for inner in value) + "]"
    return scalar(value)


def scalar(value: str | int | float | None) -> str:
    """Return a value that reads back exactly, also in YAML 1.1."""
    if value is None:
        return "null"
    if isinstance(value, int):
        return str(value).lower()  # as YAML writes booleans
    if isinstance(value, float):
        text = repr(value)
        digits, e, exponent = text.partition("e")
        # Many readers take "1e-05", without a point, for text.
        return f"{digits}.0e{exponent}" if e and "." not in digits else text
    if _WORD.match(value) and means_itself(value):
        return value
    quoted: str = yaml.safe_dump(value, default_style='"', allow_unicode=True, width=2**30)
    return quoted.rstrip("\n")
