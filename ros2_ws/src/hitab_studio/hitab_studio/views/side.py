"""The panel at the right, which shows one of its tabs."""

from __future__ import annotations

from typing import Any

from hitab_studio.pages.page import Page
from hitab_studio.swarm.absence import absence
from hitab_studio.views import (
    tab_examples,
    tab_learned,
    tab_library,
    tab_record,
    tab_swarm,
    tab_teach,
)

TABS = {
    "teach": tab_teach.context,
    "learned": tab_learned.context,
    "examples": tab_examples.context,
    "library": tab_library.context,
    "swarm": tab_swarm.context,
    "record": tab_record.context,
}

AGO_MEANS = (
    "Seconds from the situation of the example until the command reached the agent, as the agent "
    "estimates them from your commands. Type another number to correct it."
)

IN_REPLAY = ("learned", "record")
"""Tabs available in a replay; the others show the present swarm."""


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the panel's template."""
    training = page.training
    live = page.agent and page.player is None
    absent = absence(page.studio.known, page.agent) if live else None
    tabs = [tab for tab in TABS if page.player is None or tab in IN_REPLAY]
    shown = page.tab if page.tab in tabs else tabs[0]
    return {
        "tabs": tabs,
        "tab": shown,
        "absent": absent,
        "ago_means": AGO_MEANS,
        "asks": bool(live) and not page.watched.vocabulary.domain,
        "counts": {
            "examples": len(training.examples) if training is not None else 0,
            "teach": len(training.questions) if training is not None and page.is_training else 0,
        },
        **TABS[shown](page),
    }
