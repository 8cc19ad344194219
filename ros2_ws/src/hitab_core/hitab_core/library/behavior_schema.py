"""The formats of behavior files; `hitab_core.library.behavior_model` has the newest's keys."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from hitab_core.errors import LibraryError, newer_format
from hitab_core.library.yaml_places import Document

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
