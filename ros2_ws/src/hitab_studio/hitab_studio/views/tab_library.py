"""The learned behaviors of the agent, with their versions."""

from __future__ import annotations

from typing import Any

from hitab_core import automaton_as_text
from hitab_studio.pages.page import Page


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the tab's template."""
    watched = page.watched
    behavior = watched.behaviors.get(page.behavior)
    text = ""
    if behavior is not None and behavior.transitions:
        text = automaton_as_text(behavior, trees=False)
    return {
        "trained": sorted(watched.vocabulary.trained),
        "behavior": behavior,
        "rules": text.splitlines(),
    }
