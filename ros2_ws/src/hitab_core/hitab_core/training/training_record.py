"""The steps of a training that change its examples, as the journal records them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hitab_core.example import ExampleKind
from hitab_core.example_codec import example_of, values_of
from hitab_core.training.example_log import ExampleLog
from hitab_core.training.undo import Edit


def prepared(log: ExampleLog, record: Mapping[str, Any]) -> Edit | None:
    """Return the edit of a log that a record describes; None: no edit.

    Raises:
        TrainingError: if it is not possible.
    """
    match record["do"]:
        case "command":
            return log.addition([example_of(e) for e in record["examples"]])
        case "undo":
            return log.history.undo()
        case "redo":
            return log.history.redo()
        case "delete":
            return log.deletion(record["numbers"])
        case "add":
            return log.answer(
                record["state"],
                values_of(record["features"]),
                record["next_state"],
                ExampleKind(record["kind"]),
            )
        case "relabel":
            return log.relabeling(record["numbers"], record["next_state"])
    return None
