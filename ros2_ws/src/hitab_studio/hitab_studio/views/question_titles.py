"""The agent's questions about its examples, each with its answers."""

from __future__ import annotations

from hitab_msgs.msg import Question

from hitab_studio.pages.page import Page

WHEN_UNSURE = {
    "go_on": ("go on", "it decides nevertheless"),
    "halt": ("halt", "it does nothing until it is sure"),
    "hand_back": ("hand back", "you decide, as in training"),
}

TITLES = {
    Question.CONTRADICTION: "Two commands disagree",
    Question.UNSHOWN: "Never shown",
    Question.LATE: "When was it due?",
    Question.CORRECTION: "Which state was wrong?",
    Question.FEATURE: "Which feature is meant?",
}


def when_unsure(page: Page) -> str:
    """Return the agent's setting for unsure decisions, for people."""
    status = page.status
    return WHEN_UNSURE.get(
        status.caution.when_unsure if status is not None else "", ("go on", "")
    )[0]
