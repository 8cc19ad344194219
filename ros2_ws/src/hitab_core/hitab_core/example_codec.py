"""Examples as plain data: how the journal and a behavior file spell them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hitab_core.example import Example, ExampleKind


def example_record(example: Example) -> dict[str, Any]:
    """Return an example as the journal spells it."""
    return {
        "state": example.state,
        "features": list(example.features),
        "next_state": example.next_state,
        "kind": example.kind.value,
        "number": example.number,
        "command": example.command,
        "cycle": example.cycle,
    }


def file_record(example: Example, counted: Sequence[bool]) -> dict[str, Any]:
    """Return an example as a behavior file spells it.

    Args:
        example: with one value per feature.
        counted: for each feature whether its values are whole numbers.
    """
    values = [
        int(value) if whole and float(value).is_integer() else float(value)
        for value, whole in zip(example.features, counted, strict=True)
    ]
    return {"number": example.number, **example_record(example), "features": values}


def example_of(record: Mapping[str, Any]) -> Example:
    """Read either spelling."""
    return Example(
        record["state"],
        tuple(float(value) for value in record["features"]),
        record["next_state"],
        ExampleKind(record["kind"]),
        int(record["number"]),
        int(record["command"]),
        int(record["cycle"]),
    )
