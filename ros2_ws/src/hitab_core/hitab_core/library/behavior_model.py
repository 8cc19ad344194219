"""The keys of a behavior file and their values.

`hitab_core.library.behavior_reader` checks the rest, such as that an example
has one value per feature and that a target exists.
"""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator

from hitab_core.domain import FeatureKind
from hitab_core.example import CYCLE_MAX, ExampleKind
from hitab_core.library.behavior_file import FLAG
from hitab_core.library.yaml_models import Record, among, read_use
from hitab_core.library.yaml_places import kind_of
from hitab_core.term import VOCABULARY_NAME_RULE


def _matching(pattern: str, expected: str) -> AfterValidator:
    compiled = re.compile(pattern)

    def check(text: str) -> str:
        if compiled.fullmatch(text) is None:
            raise ValueError(f"is {kind_of(text)}, not {expected}")
        return text

    return AfterValidator(check)


def _value(value: Any) -> Any:
    if value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
        raise ValueError(f"must be a number or null, not {kind_of(value)}")
    return value


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


Name = Annotated[str, _matching("[A-Za-z][A-Za-z0-9_]*", f"a name; {VOCABULARY_NAME_RULE}")]
Digest = Annotated[
    str, _matching("[0-9a-f]{64}", "a digest (64 characters 0-9 and a-f); was it cut off?")
]
Count = Annotated[int, Field(ge=0, le=CYCLE_MAX), BeforeValidator(_whole)]
PositiveCount = Annotated[Count, Field(ge=1)]
Value = Annotated[float | None, PlainValidator(_value)]
Used = Annotated[str, AfterValidator(read_use)]


class ExpectationRecord(Record):
    """See `hitab_core.library.expectation.Expectation`."""

    name: Annotated[str, Field(min_length=1)]
    state: str
    features: dict[str, Annotated[float, Field(allow_inf_nan=False)]]
    next_state: str
    blocks: bool = False


class NumbersRecord(Record):
    """The numbers that the next state of an example was commanded with."""

    example: PositiveCount
    values: list[Annotated[float, Field(allow_inf_nan=False)]]


class OptionalRecord(Record, extra="allow"):
    """Sections by name that may be missing. A later HiTAB may add others."""

    expectations: list[ExpectationRecord] = Field(default_factory=list)
    chosen: list[Used] = Field(default_factory=list)
    numbers: list[NumbersRecord] = Field(default_factory=list)


class DomainRecord(Record):
    """The domain in which a behavior was trained."""

    name: Name
    version: str
    signature: str


class FeatureRecord(Record):
    """A feature that its examples have values of."""

    feature: Used
    kind: Annotated[str, among([*(kind.value for kind in FeatureKind), FLAG])]
    unit: str = ""
    period: float = Field(default=1.0, gt=0)
    categories: list[str] = Field(default_factory=list)


class ExampleRecord(Record):
    """An example, with one value per feature."""

    number: PositiveCount
    state: str
    features: list[Value]
    next_state: str
    kind: Annotated[str, among(kind.value for kind in ExampleKind)]
    command: Count
    cycle: Count
    ago: float = Field(ge=0)
    optional: dict[str, Any] = Field(default_factory=dict)


class ReadingRecord(Record):
    """Further readings at the time of a command."""

    command: Count
    values: list[Value]


class ProvenanceRecord(Record):
    """Origin of a behavior."""

    version: PositiveCount
    created: str
    author: str
    agent: str
    tool: str
    earlier: str
    note: str


class BehaviorRecord(Record):
    """A behavior trained by demonstration."""

    format: int
    name: Name
    description: str
    domain: DomainRecord
    parameters: list[Name]
    states: list[Used]
    features: list[FeatureRecord]
    classifier: str
    examples: list[ExampleRecord]
    trees: dict[str, Digest]
    uses: dict[str, str]
    readable: list[Used]
    readings: list[ReadingRecord]
    provenance: ProvenanceRecord
    optional: OptionalRecord = Field(default_factory=OptionalRecord)
    checksum: Digest
