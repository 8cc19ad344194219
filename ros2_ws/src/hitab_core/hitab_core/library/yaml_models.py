"""Typed models of YAML files; errors name the line.

Import this where a file is read, not at the top: pydantic takes a while to load.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import Annotated, Any, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    Tag,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from hitab_core.library.yaml_places import Complaints, Document, Place, kind_of
from hitab_core.term import Term
from hitab_core.texts.errors import HitabError, newer_format
from hitab_core.texts.vocabulary import has


class Record(BaseModel):
    """A mapping with these keys and no others; nothing stands for an empty one."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, defer_build=True)

    @classmethod
    def known(cls) -> list[str]:
        """Return the keys in a file; a field that is no key has an alias with a colon."""
        names = [field.alias or name for name, field in cls.model_fields.items()]
        return [name for name in names if not name.startswith(":")]

    def but(self, **changes: Any) -> Self:
        """Return the same with changes, which are not checked."""
        return self.model_copy(update=changes)

    @model_validator(mode="before")
    @classmethod
    def _note(cls, value: Any, info: ValidationInfo) -> Any:
        """Note the type of this mapping, for `read_record`."""
        if info.context is not None:
            info.context[id(value)] = cls
        return {} if value is None else value


R = TypeVar("R", bound="Record")


def among(choices: Iterable[str]) -> AfterValidator:
    """Return a check that a text is one of these."""
    known = list(choices)

    def check(text: str) -> str:
        if text not in known:
            raise ValueError(f"is {kind_of(text)}, which is not known {has(known, text)}")
        return text

    return AfterValidator(check)


@dataclass(frozen=True)
class OneOf:
    """Marks a record as one of several, each with a key that only this one has."""

    records: Mapping[str, type[Record]]

    def _tag(self, value: Any) -> str | None:
        if isinstance(value, Record):
            return next(
                f"<{key}>" for key, record in self.records.items() if type(value) is record
            )
        found = {key: self.records[key] for key in value if key in self.records}
        own = [k for k in found if not any(k in r.known() for n, r in found.items() if n != k)]
        return f"<{own[0]}>" if len(own) == 1 else None

    def _check(self, value: Any) -> Any:
        if isinstance(value, Record):
            return value
        if not isinstance(value, dict):
            raise ValueError(f"must be `key: value` lines, not {kind_of(value)}")
        if self._tag(value) is None:
            fault = "needs exactly one kind" if {*value} & {*self.records} else "has no known kind"
            raise ValueError(f"{fault} {has(self.records, *value)}")
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        any_of: Any = reduce(
            or_, (Annotated[record, Tag(f"<{key}>")] for key, record in self.records.items())
        )
        checks = Discriminator(self._tag), BeforeValidator(self._check)
        return handler.generate_schema(Annotated[any_of, *checks])


@dataclass(frozen=True)
class MappingOr:
    """Marks a value that is read as one type if it is a mapping, and else as another."""

    mapping: Any
    other: Any

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        def tag(value: Any) -> str:
            return "<mapping>" if isinstance(value, dict | Record) else "<other>"

        mapping: Any = Annotated[self.mapping, Tag("<mapping>")]
        other: Any = Annotated[self.other, Tag("<other>")]
        return handler.generate_schema(Annotated[mapping | other, Discriminator(tag)])


def read_use(text: str) -> Term:
    """Return the term of a behavior, feature or target; a ValueError describes the fault."""
    try:
        return Term.parse(text)
    except HitabError as error:
        raise ValueError(str(error)) from None


def _tuple(value: Any) -> Any:
    found = value if isinstance(value, list | tuple) else [] if value is None else [value]
    if not all(isinstance(item, str) for item in found):
        raise ValueError(f"must be a list of strings, such as [a, b], not {kind_of(value)}")
    return tuple(found)


Format = Annotated[int, Field(ge=1)]
"""The format version of a file."""

Texts = Annotated[tuple[str, ...], BeforeValidator(_tuple)]
"""A list of texts; a single text counts as one."""

NONE_IS_EMPTY = BeforeValidator(lambda value: {} if value is None else value)
"""Marks a mapping that may be left empty, as a record's mapping may."""

Names = Annotated[dict[str, str], NONE_IS_EMPTY]
"""Texts by name."""


def read_record(model: type[R], value: Any, complaints: Complaints) -> R | None:
    """Read the content of a document; None after complaints."""
    records: dict[int, type[Record]] = {}
    try:
        return model.model_validate(value, context=records)
    except ValidationError as wrong:
        for error in wrong.errors(include_url=False):
            path, around = _place(value, error["loc"])
            complaints.add(path, _in_words(error, path, records.get(id(around))))
        return None


def open_record(model: type[R], document: Document, newest: int) -> R:
    """Read a document as a record; without ``format:`` it has the first format.

    Args:
        model: model of the record.
        document: the document to read.
        newest: the newest format that the caller reads.

    Raises:
        HitabError: of the document's type, naming every fault, by file and line.
    """
    complaints = Complaints(document)
    found = document.value.get("format", 1) if isinstance(document.value, dict) else 1
    if isinstance(found, int) and found > newest:
        complaints.add(("format",), newer_format(found, newest))
        complaints.raise_any()  # other faults may be new features
    read = read_record(model, document.value, complaints)
    complaints.raise_any()
    assert read is not None
    return read


def _place(value: Any, loc: Sequence[str | int]) -> tuple[Place, Any]:
    """Return the path of an error, without pydantic's own words, and the value around it."""
    path: list[str | int] = []
    around = value
    for key in loc:
        inside = key in value if isinstance(value, dict) else isinstance(key, int)
        if inside:
            around, value = value, value[key]
            path.append(key)
    return tuple(path), around


def _in_words(error: Any, path: Place, record: type[Record] | None) -> str:
    kind, value, limits = error["type"], error["input"], error.get("ctx", {})
    what = f"`{path[-1]}:`" if path else "the file"
    if path and isinstance(path[-1], int):
        what = f"item {path[-1] + 1} of `{path[-2]}:`"
    if kind == "missing":
        return f"`{error['loc'][-1]}:` is missing here; add it, or was the file cut off?"
    if kind == "extra_forbidden":
        return f"{what} is not known here {has(record.known() if record else (), path[-1])}"
    if kind == "value_error":
        return f"{what} {limits['error']}"
    wanted = _WANTED[kind].format(**limits) if kind in _WANTED else error["msg"]
    return f"{what} must be {wanted}, not {limits.get('actual_length', kind_of(value))}"


_WANTED = {
    "string_type": "a text",
    "int_type": "a whole number",
    "float_type": "a number",
    "bool_type": "true or false",
    "list_type": "a list",
    "dict_type": "`key: value` lines",
    "model_type": "`key: value` lines",
    "greater_than": "more than {gt:g}",
    "greater_than_equal": "at least {ge:g}",
    "less_than_equal": "at most {le:g}",
    "too_short": "a list of at least {min_length}",
    "too_long": "a list of at most {max_length}",
}
"""Requirements in words, by pydantic's types of errors."""
