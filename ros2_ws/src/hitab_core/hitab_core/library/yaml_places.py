"""Strict YAML: plain data only, with the line of every item for error messages.

Everything beyond plain data is refused: tags, anchors and aliases (a few lines can expand to
gigabytes), duplicate keys (the earlier one would be ignored silently), and several documents in
one file. Scalars follow YAML 1.2: ``no`` and ``2012-01-01`` are text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from hitab_core.library.durable_files import file_errors
from hitab_core.texts.errors import HitabError, LibraryError

Place = tuple[str | int, ...]
"""A place in a document: keys and indices from the root inwards."""

LARGEST = 16 * 1024 * 1024
"""Maximum characters of a document. A behavior with 10,000 examples has about two million."""

NESTING_MAX = 20
"""Maximum nesting of lists and mappings in a document."""

_INTEGER = re.compile(r"[-+]?[0-9]{1,18}\Z", re.ASCII)
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]{1,9})?\Z", re.ASCII)
_SPECIAL: Mapping[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
}
_OTHERS: Any = yaml.resolver.Resolver()
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class Document:
    """The content of a YAML text, with line numbers.

    Attributes:
        file: name of the text, for complaints.
        value: the content, of dict, list, str, int, float, bool and None.
        lines: line number, from 1, of every item, by path.
        error: type of the errors about its faults.
    """

    file: str
    value: Any
    lines: Mapping[Place, int]
    error: type[HitabError] = LibraryError

    def line(self, path: Place = ()) -> int:
        """Return the line of the item at ``path``, or of the nearest item around it."""
        while path not in self.lines:
            path = path[:-1]
        return self.lines[path]

    def place(self, path: Place = ()) -> str:
        """Return ``file:line`` of the item at ``path``."""
        return f"{self.file}:{self.line(path)}"


class Complaints:
    """All faults of a document, gathered so that a user can fix them in one go."""

    def __init__(self, document: Document) -> None:
        """Start without complaints about ``document``."""
        self.document = document
        self._found: list[tuple[int, str]] = []

    def __len__(self) -> int:
        """Return how many complaints there are."""
        return len(self._found)

    def add(self, path: Place, text: str) -> None:
        """Note a fault at ``path``, with the way out."""
        found = (self.document.line(path), text)
        if found not in self._found:
            self._found.append(found)

    def raise_any(self) -> None:
        """Raise one error with all complaints, sorted by line, if there are any."""
        if self._found:
            raise self.document.error(
                "\n".join(
                    f"{self.document.file}:{line}: {text}" for line, text in sorted(self._found)
                )
            )


def open_yaml(path: Path, *, error: type[HitabError] = LibraryError) -> Document:
    """Read a file that is one YAML document; see `read_text` and `read_yaml`."""
    return read_yaml(read_text(path, error=error), str(path), error=error)


def read_text(path: Path, *, error: type[HitabError] = LibraryError) -> str:
    """Return the text of a file.

    Raises:
        error: if it cannot be read, is not text or is too large; naming the way out.
    """
    with file_errors(path, "read", error=error):
        if path.is_fifo():
            raise error(f"{path}: is a pipe, not a file; remove it")
        with path.open("rb") as file:
            data = file.read(4 * LARGEST + 1)
    if len(data) > 4 * LARGEST:
        raise error(f"{path}: has more than {4 * LARGEST} bytes; is this the right file?")
    try:
        return data.decode()
    except UnicodeDecodeError as wrong:
        line = data.count(b"\n", 0, wrong.start) + 1
        raise error(
            f"{path}:{line}: is not UTF-8 text; save it as UTF-8, or bring back a copy"
        ) from None


def read_yaml(text: str, file: str, *, error: type[HitabError] = LibraryError) -> Document:
    """Read a text that is one YAML document.

    Args:
        text: the document.
        file: name of the file, for errors.
        error: type of the errors about its faults.

    Raises:
        error: naming the file and line of anything that is not YAML, or not plain data.
    """
    if len(text) > LARGEST:
        raise error(f"{file}: has {len(text)} characters; the limit is {LARGEST}")
    try:
        text.encode()
        return _Reader(file, error).document(text)
    except UnicodeEncodeError as wrong:
        raise error(
            f"{file}: has a lone surrogate at character {wrong.start}; remove it"
        ) from None
    except yaml.MarkedYAMLError as wrong:
        mark = wrong.problem_mark or wrong.context_mark
        line = mark.line + 1 if mark else 1
        context = f" {wrong.context}" if wrong.context else ""
        if mark and text[mark.index : mark.index + 1] == "\t":
            raise error(f"{file}:{line}: not YAML: a tab; indent with spaces") from None
        raise error(
            f"{file}:{line}: not YAML: {wrong.problem}{context}; look for a missing bracket, "
            "quote or colon here or just above, or for a file that was cut off"
        ) from None
    except yaml.reader.ReaderError as wrong:
        line = text.count("\n", 0, wrong.position) + 1 if wrong.position >= 0 else 1
        raise error(
            f"{file}:{line}: not YAML: a character that is not allowed "
            f"(code {wrong.character}); remove it"
        ) from None
    except (ValueError, OverflowError) as wrong:  # PyYAML accepts escapes that are no characters
        raise error(f"{file}: not YAML: {wrong}; look for a wrong escape such as \\U") from None


def resolved_scalar(text: str) -> Any:
    """Return the value of an unquoted scalar."""
    if text in _SPECIAL:
        return _SPECIAL[text]
    if _INTEGER.match(text):
        return int(text)
    return float(text) if _FLOAT.match(text) else text


def means_itself(text: str) -> bool:
    """Return whether an unquoted word reads as this text, here and in YAML 1.1."""
    tag = _OTHERS.resolve(yaml.ScalarNode, text, (True, False))
    return resolved_scalar(text) == text and bool(tag == "tag:yaml.org,2002:str")


def kind_of(value: Any) -> str:
    """Return a value in words, for complaints."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return "a list"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, str):
        return f'the text "{value if len(value) <= 40 else value[:37] + "..."}"'
    return str(value)


class _Reader:
    """Builds a document from the parser's events, never deeper than `NESTING_MAX`."""

    def __init__(self, file: str, error: type[HitabError]) -> None:
        self._file = file
        self._error = error
        self._lines: dict[Place, int] = {}

    def document(self, text: str) -> Document:
        events = yaml.parse(text, Loader=_Loader)
        value: Any = None
        documents = 0
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise self._refusal(event, "a second document; put it into a file of its own")
                value = self._value(next(events), events, ())
        if not documents:
            raise self._error(f"{self._file}:1: is empty; write it again, or bring back a copy")
        return Document(self._file, value, self._lines, self._error)

    def _value(self, event: Any, events: Iterator[Any], path: Place) -> Any:
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            raise self._refusal(
                event, "an anchor or alias (& or *); write out the value, or quote it"
            )
        if event.tag is not None and event.tag != "!":
            raise self._refusal(event, f'the tag "{event.tag}"; leave it out, or quote the value')
        if len(path) > NESTING_MAX:
            raise self._refusal(event, f"more than {NESTING_MAX} levels of lists and mappings")
        self._lines.setdefault(path, _line(event))
        if isinstance(event, yaml.ScalarEvent):
            plain = not event.style and event.implicit[0]
            return resolved_scalar(event.value) if plain else event.value
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(events, path)
        return self._mapping(events, path)

    def _sequence(self, events: Iterator[Any], path: Place) -> list[Any]:
        items: list[Any] = []
        while not isinstance(event := next(events), yaml.SequenceEndEvent):
            items.append(self._value(event, events, (*path, len(items))))
        return items

    def _mapping(self, events: Iterator[Any], path: Place) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        while not isinstance(event := next(events), yaml.MappingEndEvent):
            if not isinstance(event, yaml.ScalarEvent) or event.anchor or event.tag:
                raise self._refusal(event, "a key that is not a plain name")
            key: str = event.value
            inner = (*path, key)
            if key in mapping:
                raise self._refusal(
                    event,
                    f'the key "{key}" twice (first at line {self._lines[inner]}); remove one',
                )
            self._lines[inner] = _line(event)
            mapping[key] = self._value(next(events), events, inner)
        return mapping

    def _refusal(self, event: Any, what: str) -> HitabError:
        return self._error(f"{self._file}:{_line(event)}: has {what}")


def _line(event: Any) -> int:
    line: int = event.start_mark.line + 1
    return line
