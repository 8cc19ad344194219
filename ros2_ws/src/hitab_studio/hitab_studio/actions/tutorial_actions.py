"""Actions that open, leave, take up and skip steps of the tutorial."""

from __future__ import annotations

from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page
from hitab_studio.pages.page_parts import TutorialProgress


@action("tutorial-recall")
async def recall(page: Page, data: Data) -> None:
    """Take up where the person left, as kept by the browser."""
    kept = data.get("kept") or {}
    page.tutorial = TutorialProgress(
        is_known=True,
        is_open=bool(kept.get("open")),
        is_finished=bool(kept.get("finished")),
        passed=set(map(str, kept.get("passed", ()))),
    )


@action("tutorial")
async def tutorial(page: Page, data: Data) -> None:
    """Open the tutorial where the person left, or again from its beginning."""
    page.close_dialog()
    if data.get("anew"):
        page.tutorial.passed.clear()
    page.tutorial.is_open = True


@action("tutorial-leave")
async def leave(page: Page, data: Data) -> None:
    """Close the tutorial; where the person is remains known."""
    page.tutorial.is_open = False


@action("tutorial-skip")
async def skip(page: Page, data: Data) -> None:
    """Go on to the next step, from one that can be skipped."""
    page.tutorial.passed.add(str(data["name"]))
