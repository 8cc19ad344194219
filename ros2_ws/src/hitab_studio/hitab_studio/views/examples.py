"""The table of examples, contradictions, and the effect of the last change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hitab_client import Learned
from hitab_core import Example, shown_unit
from hitab_studio import unavailable
from hitab_studio.learned import is_contradicted, most_probable, superseding
from hitab_studio.session import Session, Table
from hitab_studio.views.numbers import measure


@dataclass(frozen=True)
class Line:
    """One example.

    Attributes:
        decided: the present decision in its situation, if it differs.
        against: numbers of the examples that contradict it.
        superseded: why nothing is learned from it; "" if something is.
        known: whether the situation in which it was recorded is known.
        still: why it cannot be due at another time; "" if it can.
        values: of the features that are shown, for people, by name.
    """

    example: Example
    decided: str
    against: tuple[int, ...]
    superseded: str
    known: bool
    still: str
    marked: bool
    values: tuple[tuple[str, str], ...]


def context(session: Session) -> dict[str, Any]:
    """Return what the tab shows."""
    training = session.watched.training
    if training is None:
        return {"lines": [], "columns": [], "total": 0}
    every = _lines(session, training)
    lines = [line for line in every if _shown(line, session.table)]
    _sort(lines, training, session.table)
    parameters = set(training.parameters)
    states = [
        b
        for b in (*training.states, *session.watched.vocabulary.behaviors)
        if not (set(_arguments(b)) - parameters - set(session.watched.vocabulary.targets))
    ]
    return {
        "lines": lines,
        "columns": _columns(training, session.table),
        "units": dict(zip(training.features, map(shown_unit, training.units), strict=False)),
        "total": len(training.examples),
        "table": session.table,
        "contradictions": sum(bool(line.against) for line in every),
        "states": [s for s in dict.fromkeys([*states, "Done", "Failed"]) if s != training.name],
        "change": session.watched.change,
        "marked": len(session.table.marked),
        "superseded": any(line.superseded for line in every),
        "timed": not all(line.still for line in every),
    }


def _columns(training: Learned, table: Table) -> list[str]:
    """Return the features that have a column."""
    return [feature for feature in training.features if feature not in table.hidden]


def _arguments(behavior: str) -> tuple[str, ...]:
    inner = behavior.partition("(")[2].rstrip(")")
    return tuple(part.strip() for part in inner.split(",")) if inner else ()


def _lines(session: Session, training: Learned) -> list[Line]:
    against = is_contradicted(training.examples)
    superseded = superseding(training.examples)
    moments = session.shared.store.known.moments
    columns = _columns(training, session.table)
    kinds = {f: s.kind for f, s in zip(training.features, training.scales, strict=True)}
    units = dict(zip(training.features, training.units, strict=False))
    lines = []
    for example in training.examples:
        values = dict(zip(training.features, example.features, strict=True))
        decided = most_probable(training.decides(example.state, example.features))
        lines.append(
            Line(
                example,
                decided if decided != example.next_state and example.is_learned else "",
                tuple(against.get(example.number, ())),
                superseded_by(superseded.get(example.number)),
                moments.of(session.agent, training.name, example.number, example.cycle)
                is not None,
                unavailable.standing_still(session, example),
                example.number in session.table.marked,
                tuple((c, _cell(values[c], kinds[c], units.get(c, ""))) for c in columns),
            )
        )
    return lines


def _cell(value: float, kind: str, unit: str) -> str:
    """Return a value for people without its unit, which stands in the title of the column."""
    return measure(value, kind, unit).removesuffix(f" {shown_unit(unit)}")


def superseded_by(numbers: list[int] | None) -> str:
    """Say why nothing is learned from a superseded example; "" for another one."""
    if numbers is None:
        return ""
    examples = "example" if len(numbers) == 1 else "examples"
    by = f"{examples} {', '.join(map(str, numbers))}" if numbers else "a command"
    return f"superseded by {by}: this was only assumed, so nothing is learned from it"


def _shown(line: Line, table: Table) -> bool:
    example = line.example
    if table.kind == "contradicting":
        if not line.against:
            return False
    elif table.kind and example.kind.value != table.kind:
        return False
    text = table.text.lower()
    return text in f"{example.state} {example.next_state}".lower()


def _sort(lines: list[Line], training: Learned, table: Table) -> None:
    features = training.features

    def key(line: Line) -> Any:
        example = line.example
        if table.sort in features:
            return (example.features[features.index(table.sort)], example.number)
        if table.sort == "state":
            return (example.state, example.number)
        if table.sort == "ago":
            return (example.ago, example.number)
        if table.sort == "next":
            return (example.next_state, example.number)
        return (example.number,)

    lines.sort(key=key, reverse=table.descending)
