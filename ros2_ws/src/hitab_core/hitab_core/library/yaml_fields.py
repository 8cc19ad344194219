"""Typed access to the fields of a YAML mapping, gathering complaints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from hitab_core.errors import newer_format
from hitab_core.library.yaml_places import Complaints, Place
from hitab_core.vocabulary import has

REQUIRED: Any = object()


class Fields:
    """A mapping somewhere in a document.

    Ask for each field by name and type. A missing field or one of the wrong type becomes a
    complaint; at :meth:`done`, so does any field that was not asked for.
    """

    def __init__(self, complaints: Complaints, path: Place = ()) -> None:
        self.complaints = complaints
        self.path = path
        value: Any = complaints.document.value
        for key in path:
            value = value[key]
        if value is None:
            value = {}
        if not isinstance(value, dict):
            self.complain(f"needs `key: value` lines here, not {kind_of(value)}")
            value = {}
        self._value: dict[str, Any] = value
        self._asked: set[str] = set()

    def __contains__(self, key: str) -> bool:
        return key in self._value

    def complain(self, text: str, *inner: str | int) -> None:
        """Note a complaint about this mapping, or about an item in it."""
        self.complaints.add((*self.path, *inner), text)

    def check_format(self, newest: int) -> None:
        """Refuse a file of a newer format; a file without ``format:`` has the first.

        Args:
            newest: the newest format that the caller reads.

        Raises:
            HitabError: the document's, at once, since what else seems wrong may be new.
        """
        found = self.integer("format", 1, least=1)
        if isinstance(found, int) and found > newest:
            self.complain(newer_format(found, newest), "format")
            self.complaints.raise_any()

    def names(self) -> list[str]:
        """Return the names of all fields, in order; they count as asked for."""
        self._asked.update(self._value)
        return list(self._value)

    def raw(self, key: str, default: Any = REQUIRED) -> Any:
        """Return a field of any type."""
        self._asked.add(key)
        if key in self._value:
            return self._value[key]
        if default is REQUIRED:
            self.complain(f"`{key}:` is missing here")
            return None
        return default

    def text(
        self, key: str, default: Any = REQUIRED, *, among: Iterable[str] | None = None
    ) -> Any:
        """Return a text field, which must be one of ``among``, if given."""
        value = self._typed(key, default, str, "a text")
        if among is not None and isinstance(value, str) and value != default:
            choices = list(among)
            if value not in choices:
                self.complain(
                    f"`{key}: {value}` is not known {has(choices, value)}",
                    key,
                )
        return value

    def number(self, key: str, default: Any = REQUIRED, *, above: float | None = None) -> Any:
        """Return a number field as a float."""
        value = self._typed(key, default, (int, float), "a number")
        if isinstance(value, int | float) and above is not None and not value > above:
            self.complain(f"`{key}: {value}` must be more than {above:g}", key)
        return float(value) if isinstance(value, int | float) else value

    def integer(self, key: str, default: Any = REQUIRED, *, least: int | None = None) -> Any:
        """Return an integer field."""
        value = self._typed(key, default, int, "a whole number")
        if isinstance(value, int) and least is not None and value < least:
            self.complain(f"`{key}: {value}` must be at least {least}", key)
            return default if default is not REQUIRED else least
        return value

    def flag(self, key: str, default: Any = REQUIRED) -> Any:
        """Return a boolean field."""
        return self._typed(key, default, bool, "true or false")

    def texts(self, key: str, default: Any = REQUIRED) -> Any:
        """Return a field with a list of texts as a tuple; a single text counts as a list."""
        value = self.raw(key, default)
        if value is default or value is None:
            return () if value is None else value
        if isinstance(value, str):
            return (value,)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            self.complain(f"`{key}:` must be a list of strings, such as [a, b]", key)
            return ()
        return tuple(value)

    def inner(self, key: str) -> Fields:
        """Return the mapping under ``key``; empty if there is none."""
        self._asked.add(key)
        if key not in self._value:
            return _Nothing(self)
        return Fields(self.complaints, (*self.path, key))

    def done(self, **meant: str) -> None:
        """Complain about fields that were not asked for.

        Args:
            meant: the names of fields that people call otherwise, by what they call them.
        """
        for key in self._value:
            if key not in self._asked:
                way = f"; write `{meant[key]}:`" if key in meant else f" {has(self._asked, key)}"
                self.complain(f"`{key}:` is not known here{way}", key)

    def _typed(self, key: str, default: Any, types: Any, what: str) -> Any:
        value = self.raw(key, default)
        if value is default or (value is None and key not in self._value):
            return value
        wrong_bool = isinstance(value, bool) and types is not bool
        if wrong_bool or not isinstance(value, types):
            self.complain(f"`{key}:` must be {what}, not {kind_of(value)}", key)
            return default if default is not REQUIRED else None
        return value


class _Nothing(Fields):
    """The fields of a missing mapping."""

    def __init__(self, around: Fields) -> None:
        self.complaints = around.complaints
        self.path = around.path
        self._value = {}
        self._asked = set()


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
