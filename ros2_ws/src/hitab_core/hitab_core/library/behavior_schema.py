"""The schema of a behavior file: its keys and their values.

`hitab_core.library.behavior_reader` checks what a schema cannot express, such as that an example
has one value per feature and that a target exists.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from hitab_core.domain import FeatureKind
from hitab_core.errors import LibraryError, newer_format
from hitab_core.example import ExampleKind
from hitab_core.library.yaml_places import Complaints, Document
from hitab_core.use import NAME_RULE

FORMAT = 3
"""The format version that is written."""

FLAG = "flag"
"""The kind of a feature that is true if the active sub-behavior has raised a flag."""

SUFFIX = ".hfa.yaml"
"""Ending of a behavior file's name."""


def _with_readings(content: dict[str, Any]) -> dict[str, Any]:
    """Convert format 1, whose examples were all due when they were commanded."""
    # What is no list of records is reported by the schema.
    examples = content.get("examples")
    if isinstance(examples, list):
        examples = [{**e, "ago": 0.0} if isinstance(e, dict) else e for e in examples]
    return {**content, "format": 2, "examples": examples, "readable": [], "readings": []}


def _of_words_used(content: dict[str, Any]) -> dict[str, Any]:
    """Convert format 2, whose signature was of all words of the domain, also unused ones."""
    domain = content.get("domain")
    if isinstance(domain, dict):
        domain = {**domain, "signature": ""}
    return {**content, "format": 3, "domain": domain}


MIGRATIONS: Mapping[int, Callable[[dict[str, Any]], dict[str, Any]]] = {
    1: _with_readings,
    2: _of_words_used,
}
"""For each older format, a function that converts a file's content to the next one."""

_NAME = {"type": "string", "pattern": r"^[A-Za-z][A-Za-z0-9_]*\Z"}
_TEXT = {"type": "string"}
_COUNT = {"type": "integer", "minimum": 0, "maximum": 10**15}
_VALUE = {"type": ["number", "null"]}
_DIGEST = {"type": "string", "pattern": r"^[0-9a-f]{64}\Z"}


def _record(needed: Mapping[str, Any], optional: Mapping[str, Any] | None = None) -> Any:
    return {
        "type": "object",
        "additionalProperties": False,
        "required": list(needed),
        "properties": {**needed, **(optional or {})},
    }


def _list(items: Any) -> Any:
    return {"type": "array", "items": items}


SCHEMA: Mapping[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": "A behavior trained by demonstration",
    **_record(
        {
            "format": {"const": FORMAT},
            "name": _NAME,
            "description": _TEXT,
            "domain": _record({"name": _NAME, "version": _TEXT, "signature": _TEXT}),
            "parameters": _list(_NAME),
            "states": _list(_TEXT),
            "features": _list(
                _record(
                    {
                        "feature": _TEXT,
                        "kind": {"enum": [*(kind.value for kind in FeatureKind), FLAG]},
                    },
                    {
                        "unit": _TEXT,
                        "period": {"type": "number", "exclusiveMinimum": 0},
                        "categories": _list(_TEXT),
                    },
                )
            ),
            "classifier": _TEXT,
            "examples": _list(
                _record(
                    {
                        "number": {**_COUNT, "minimum": 1},
                        "state": _TEXT,
                        "features": _list(_VALUE),
                        "next_state": _TEXT,
                        "kind": {"enum": [kind.value for kind in ExampleKind]},
                        "command": _COUNT,
                        "cycle": _COUNT,
                        "ago": {"type": "number", "minimum": 0},
                    }
                )
            ),
            "trees": {"type": "object", "additionalProperties": _DIGEST},
            "uses": {"type": "object", "additionalProperties": _TEXT},
            "readable": _list(_TEXT),
            "readings": _list(_record({"command": _COUNT, "values": _list(_VALUE)})),
            "provenance": _record(
                {
                    "version": {**_COUNT, "minimum": 1},
                    "created": _TEXT,
                    "author": _TEXT,
                    "agent": _TEXT,
                    "tool": _TEXT,
                    "earlier": _TEXT,
                    "note": _TEXT,
                }
            ),
            "checksum": _DIGEST,
        }
    ),
}

_TYPES = {
    "string": "text",
    "integer": "a whole number",
    "number": "a number",
    "null": "null",
    "array": "a list",
    "object": "a mapping of names to values",
}


@cache
def _validator() -> Any:
    from jsonschema import Draft202012Validator  # here because importing it is slow

    return Draft202012Validator(SCHEMA)


def check_format(document: Document) -> int:
    """Return the format of a document.

    Raises:
        LibraryError: if it has none, or one that cannot be read.
    """
    if not isinstance(document.value, dict):
        raise LibraryError(
            f"{document.place()}: is not a behavior file: expected keys such as format and name"
        )
    found = document.value.get("format")
    if not isinstance(found, int) or isinstance(found, bool):
        raise LibraryError(
            f'{document.place(("format",))}: "format" is missing or not a number; '
            f"a behavior file begins with format: {FORMAT}"
        )
    if found > FORMAT:
        raise LibraryError(
            f"{document.place(('format',))}: {newer_format(found, FORMAT)}, or save the behavior "
            "with an older version"
        )
    if found < FORMAT and found not in MIGRATIONS:
        raise LibraryError(
            f"{document.place(('format',))}: has format {found}, which this HiTAB cannot read "
            f"(reads: {', '.join(str(n) for n in sorted([*MIGRATIONS, FORMAT]))}); "
            "open and save it with an older version of HiTAB first"
        )
    return found


def migrated(content: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a file, converted to the current format."""
    while content["format"] < FORMAT:
        content = MIGRATIONS[content["format"]](content)
    return content


def check_schema(content: Mapping[str, Any], complaints: Complaints) -> bool:
    """Complain about every violation of `SCHEMA`; return whether there are none."""
    well = True
    for error in _validator().iter_errors(content):
        complaints.add(tuple(error.absolute_path), _in_words(error))
        well = False
    return well


def _in_words(error: Any) -> str:
    path = list(error.absolute_path)
    subject = f'"{path[-1]}"' if path else "the file"
    if path and isinstance(path[-1], int):
        subject = f'item {path[-1] + 1} of "{path[-2]}"'
    limit, value = error.validator_value, error.instance
    match error.validator:
        case "required":
            missing = [key for key in limit if key not in value]
            return f"{subject} lacks {_quoted(missing)}; was it cut off?"
        case "additionalProperties" if isinstance(limit, bool):
            known = error.schema["properties"]
            unknown = [key for key in value if key not in known]
            return f"{subject} has {_quoted(unknown)}; the known keys are {', '.join(known)}"
        case "type":
            kinds = [limit] if isinstance(limit, str) else limit
            wanted = " or ".join(_TYPES[kind] for kind in kinds)
            return f"{subject} must be {wanted}, not {_shown(value)}"
        case "enum":
            return f"{subject} is {_shown(value)}; it must be one of {', '.join(limit)}"
        case "pattern" if limit == _DIGEST["pattern"]:
            return f"{subject} is not a digest (64 characters 0-9 and a-f); was it cut off?"
        case "pattern":
            return f"{subject} is {_shown(value)}, not a name; {NAME_RULE}"
        case "minimum":
            return f"{subject} is {_shown(value)}; it must be at least {limit}"
        case "exclusiveMinimum":
            return f"{subject} is {_shown(value)}; it must be more than {limit}"
        case "maximum":
            return f"{subject} is {_shown(value)}; it must be at most {limit}"
        case _:
            return f"{subject}: {error.message}"


def _quoted(names: list[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def _shown(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else text[:37] + "..."
