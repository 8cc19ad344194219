"""The table of examples, contradictions, and the effect of the last change."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hitab_client import Learned
from hitab_core import BoundedNumber, Example, Term, shown_unit
from hitab_studio.pages.example_effects import is_contradicted, most_probable, superseding
from hitab_studio.pages.page import Page
from hitab_studio.pages.page_parts import ExamplesTable
from hitab_studio.views.numbers import measure


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the tab's template."""
    training, table = page.training, page.table
    if training is None:
        return {"lines": [], "columns": [], "total": 0}
    moments = page.studio.known.moments
    against = is_contradicted(training.examples)
    superseded = {n: overruled_by(by) for n, by in superseding(training.examples).items()}
    lines = [e for e in training.examples if _shown(e, table, against)]
    lines.sort(key=lambda e: _key(e, training, table), reverse=table.descending)
    given = {*training.parameters, *page.watched.vocabulary.targets}
    states = [
        b
        for b in (*training.possible_states, *page.watched.vocabulary.behaviors)
        if not set(Term.parse(b).arguments) - given
    ]
    return {
        "lines": lines,
        "columns": [feature for feature in training.feature_labels if feature not in table.hidden],
        "units": dict(zip(training.feature_labels, map(shown_unit, training.units), strict=False)),
        "total": len(training.examples),
        "against": against,
        "superseded": superseded,
        "decided": lambda example: _decided(training, example),
        "known": lambda e: (page.agent, training.name, e.number, e.cycle) in moments,
        "values": lambda example: _values(training, example),
        "states": [
            page.watched.vocabulary.commandable(s)
            for s in dict.fromkeys([*states, "Done", "Failed"])
            if s != training.name
        ],
        "numbers": lambda example: _numbers(training, example),
    }


def _decided(training: Learned, example: Example) -> str:
    """Return the present decision in an example's situation, if different from the example."""
    decided = most_probable(training.decides(example.state, example.features))
    return decided if decided != example.next_state and example.is_learned else ""


def _numbers(training: Learned, example: Example) -> list[tuple[BoundedNumber, float]]:
    """Return the numbers of the command of an example."""
    wanted = training.numbers_of(Term.parse(example.next_state))
    return list(zip(wanted, example.numbers, strict=False))


def _values(training: Learned, example: Example) -> dict[str, str]:
    """Return the values of the features, for people; units are in the column titles."""
    found = {}
    for i, feature in enumerate(training.feature_labels):
        unit = training.units[i]
        text = measure(example.features[i], training.scales[i].kind, unit)
        found[feature] = text.removesuffix(f" {shown_unit(unit)}")
    return found


def overruled_by(numbers: list[int]) -> str:
    """Return the reason for which nothing is learned from an overruled example."""
    examples = "example" if len(numbers) == 1 else "examples"
    by = f"{examples} {', '.join(map(str, numbers))}" if numbers else "a command"
    return f"overruled by {by}: this was only assumed, so nothing is learned from it"


def _shown(example: Example, table: ExamplesTable, against: Mapping[int, Any]) -> bool:
    if table.kind == "contradicting":
        right = example.number in against
    else:
        right = table.kind in ("", example.kind.value)
    return right and table.text.lower() in f"{example.state} {example.next_state}".lower()


def _key(example: Example, training: Learned, table: ExamplesTable) -> tuple[Any, int]:
    columns = {"state": example.state, "next": example.next_state, "ago": example.ago}
    columns |= dict(zip(training.feature_labels, example.features, strict=True))
    return columns.get(table.sort, 0), example.number
