"""The panel at the right, which shows one of its tabs."""

from __future__ import annotations

from typing import Any

from hitab_studio.absence import absence
from hitab_studio.page_state import PageState
from hitab_studio.views import examples, learned, library, record, swarm, teach

TABS = {
    "teach": teach.context,
    "learned": learned.context,
    "examples": examples.context,
    "library": library.context,
    "swarm": swarm.context,
    "record": record.context,
}

AGO_MEANS = (
    "Seconds from the situation of the example until the command reached the agent, as the agent "
    "estimates them from your commands. Type another number to correct it."
)

IN_REPLAY = ("learned", "record")
"""Tabs that show a recording; the others are about the swarm as it is now."""


def context(session: PageState) -> dict[str, Any]:
    """Return the variables of the panel's template."""
    training = session.training
    live = session.agent and session.player is None
    absent = absence(session.shared.store.known, session.agent) if live else None
    tabs = [tab for tab in TABS if session.player is None or tab in IN_REPLAY]
    shown = session.tab if session.tab in tabs else tabs[0]
    return {
        "tabs": tabs,
        "tab": shown,
        "absent": absent,
        "ago_means": AGO_MEANS,
        "asks": bool(live) and not session.watched.vocabulary.domain,
        "counts": {
            "examples": len(training.examples) if training is not None else 0,
            "teach": len(training.questions)
            if training is not None and session.is_training
            else 0,
        },
        **TABS[shown](session),
    }
