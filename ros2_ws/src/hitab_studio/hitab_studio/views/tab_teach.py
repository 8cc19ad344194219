"""The last recorded example, and the agent's percept."""

from __future__ import annotations

from functools import partial
from typing import Any

from hitab_client.demonstrating import EARLIER_SECONDS
from hitab_core import Example
from hitab_studio.pages import unavailable
from hitab_studio.pages.example_effects import superseding
from hitab_studio.pages.page import Page
from hitab_studio.pages.ui_remedies import in_studio
from hitab_studio.views import robot_sensors
from hitab_studio.views.numbers import measure
from hitab_studio.views.perceived import perceived
from hitab_studio.views.question_titles import TITLES, when_unsure

EDITS_MAX = 6
"""Maximum number of done and of undone edits shown in the history."""


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the tab's template."""
    watched = page.watched
    training = page.training
    examples = training.examples if training is not None else ()
    last = max((e.command for e in examples), default=0)
    return {
        "recorded": [e for e in examples if e.command == last] if last else [],
        "defaults": sum(e.is_default for e in examples),
        "readings": perceived(page),
        "past": page.time.past,
        "freezing_off": unavailable.freezing(page),
        "abouts": watched.vocabulary.feature_descriptions,
        "values_of": lambda example: _values(page, example),
        "trained": sorted(page.watched.vocabulary.trained),
        "last_edits": [(text, False) for text in (training.done if training else ())[-EDITS_MAX:]]
        + [(text, True) for text in (training.undone if training else ())[:EDITS_MAX]],
        "earlier_seconds": EARLIER_SECONDS,
        "superseded": superseding(examples),
        "given_up": _wasted(page),
        "cost": training.cost if training else None,
        "questions": training.questions if training else (),
        "remarks": training.remarks if training else (),
        "in_studio": in_studio,
        "question_titles": TITLES,
        "showing_off": partial(unavailable.showing, page),
        "when_unsure": when_unsure(page),
        "sensors": robot_sensors.rows(page),
        "sensor_notes": robot_sensors.notes(page),
    }


def _wasted(page: Page) -> int:
    """Return the number of deleted or undone examples, without the superseded ones."""
    training = page.training
    if training is None or training.cost is None:
        return 0
    return max(0, training.cost.wasted - sum(not e.is_learned for e in training.examples))


def _values(page: Page, example: Example) -> list[tuple[str, str]]:
    """Return the agent's percept in an example: features with values for people."""
    training = page.training
    if training is None:
        return []
    kinds = [scale.kind for scale in training.scales]
    values = map(measure, example.features, kinds, training.units)
    return list(zip(training.feature_labels, values, strict=True))
