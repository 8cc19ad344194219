"""The present step of the tutorial, found from the state of the page, and its card."""

from __future__ import annotations

import json
from typing import Any

from hitab_studio.pages.page import Page
from hitab_studio.tutorial.steps import (
    AFTER,
    AGENT,
    GROUND,
    KEYBOARD,
    STEPS,
    TRAINING,
    TutorialStep,
    is_ours,
    is_saved,
    is_settled,
)

BEGUN = "begun"
"""Noted among the passed steps once the training has begun."""

SAVED, END = "save", "end"
"""The step that ends the training, and the last one."""


def present_step(page: Page) -> TutorialStep:
    """Return the first step of a page that is not done, and note those that stay done.

    It remains the step before until all that a request has changed has arrived.
    """
    progress = page.tutorial
    if progress.step is None or is_settled(page):
        progress.step = _first_to_do(page)
    step: TutorialStep = progress.step
    return step


def _first_to_do(page: Page) -> TutorialStep:
    progress, passed = page.tutorial, page.tutorial.passed
    if is_ours(page):
        passed -= {SAVED, *(step.name for step in AFTER)}
        passed.add(BEGUN)
    elif BEGUN in passed and is_saved(page):
        passed.add(SAVED)
    elif SAVED not in passed and page.status and not page.is_training:
        passed.clear()  # the training was discarded, or has not begun
    for step in (*GROUND, *(() if SAVED in passed else TRAINING), *AFTER):
        if step.name in passed:
            continue
        if not step.done(page):
            progress.is_finished = progress.is_finished or step.name == END
            return step
        if step.once:
            passed.add(step.name)
    raise AssertionError("the last step is never done")


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the card's template."""
    progress, passed = page.tutorial, page.tutorial.passed
    step = present_step(page) if progress.is_open else None
    kept = {"open": progress.is_open, "finished": progress.is_finished, "passed": sorted(passed)}
    found: dict[str, Any] = {"step": step, "kept": json.dumps(kept) if progress.is_known else ""}
    if step is None:
        return found
    key = page.studio.keys.of(page.watched.vocabulary.domain, step.behavior)
    thing = page.agent if step.thing == AGENT else step.thing
    return found | {
        "number": STEPS.index(step) + 1,
        "count": len(STEPS),
        "text": step.text.format(agent=page.agent, key=(key or "click").upper()),
        "marks": json.dumps(step.marks),
        "thing": thing,
        "spot": json.dumps(step.spot(page) if step.spot is not None else None),
        "keyboard": KEYBOARD if thing else "",
        "is_last": step.name == END,
        "waits": not is_settled(page),
    }
