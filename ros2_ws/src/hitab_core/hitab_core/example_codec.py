"""Examples as plain data: their form in the journal and in behavior files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hitab_core.example import Example, ExampleKind


def value_records(values: Iterable[float]) -> list[float | None]:
    """Return values as plain data: a missing one is None, since JSON and YAML know no NaN."""
    return [None if math.isnan(value) else value for value in values]


def values_of(records: Iterable[float | None]) -> tuple[float, ...]:
    """Return the values that `value_records` represents."""
    return tuple(math.nan if value is None else float(value) for value in records)


def example_record(example: Example) -> dict[str, Any]:
    """Return an example as the journal spells it."""
    numbers = {"numbers": list(example.numbers)} if example.numbers else {}
    return {**_record(example), "readings": value_records(example.readings), **numbers}


def _record(example: Example) -> dict[str, Any]:
    return {
        "state": example.state,
        "features": value_records(example.features),
        "next_state": example.next_state,
        "kind": example.kind.value,
        "number": example.number,
        "command": example.command,
        "cycle": example.cycle,
        "ago": example.ago,
    }


def file_record(example: Example, counted: Sequence[bool]) -> dict[str, Any]:
    """Return an example as a behavior file spells it, without its readings and numbers.

    Args:
        example: example with one value per feature.
        counted: by feature, whether its values are whole numbers.
    """
    values = [
        int(value) if whole and value is not None and value.is_integer() else value
        for value, whole in zip(value_records(map(float, example.features)), counted, strict=True)
    ]
    return {"number": example.number, **_record(example), "features": values}


def example_of(record: Mapping[str, Any]) -> Example:
    """Return the example that `example_record` represents."""
    return Example(
        record["state"],
        values_of(record["features"]),
        record["next_state"],
        ExampleKind(record["kind"]),
        int(record["number"]),
        int(record["command"]),
        int(record["cycle"]),
        float(record["ago"]),
        values_of(record["readings"]),
        tuple(map(float, record.get("numbers", ()))),
    )
