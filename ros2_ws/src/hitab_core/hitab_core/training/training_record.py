"""Conversion of a training's steps to journal records, and their replay."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from hitab_core.example import Example, ExampleKind
from hitab_core.training.example_log import Edit, ExampleLog


def example_record(example: Example) -> dict[str, Any]:
    """Return an example as plain data for the journal."""
    return {
        "state": example.state,
        "features": list(example.features),
        "next_state": example.next_state,
        "kind": example.kind.value,
        "number": example.number,
        "command": example.command,
        "cycle": example.cycle,
    }


def example_from_record(record: Mapping[str, Any]) -> Example:
    """Read what `example_record` wrote."""
    return Example(
        record["state"],
        tuple(float(v) for v in record["features"]),
        record["next_state"],
        ExampleKind(record["kind"]),
        int(record["number"]),
        int(record["command"]),
        int(record["cycle"]),
    )


def prepared(log: ExampleLog, record: Mapping[str, Any]) -> Edit | None:
    """Return the edit of a log that a record describes; None: no edit.

    Raises:
        TrainingError: if it is not possible.
    """
    match record["do"]:
        case "command":
            return log.addition([example_from_record(e) for e in record["examples"]])
        case "undo":
            return log.undoing()
        case "redo":
            return log.redoing()
        case "delete":
            return log.deletion(record["numbers"])
        case "relabel":
            return log.relabelling(record["numbers"], record["next_state"])
    return None


def replay(records: Iterable[Mapping[str, Any]], log: ExampleLog) -> ExampleLog:
    """Replay on ``log`` all records that follow the first one of a journal.

    Raises:
        TrainingError: if a record cannot be replayed.
    """
    for record in records:
        edit = prepared(log, record)
        if edit is not None:
            log.make(edit)
    return log
