"""Why something on the page does nothing at present; empty if it does something."""

from __future__ import annotations

from jinja2.utils import markupsafe

from hitab_client import SwarmError, Training
from hitab_core import START
from hitab_studio.page import CHOOSE_FIRST, Page


def off(reason: str) -> markupsafe.Markup:
    """Return the attributes of a button that does nothing at present and says why when pressed.

    It can be reached with the keyboard, unlike a disabled one. Place them before ``title``.
    """
    if not reason:
        return markupsafe.Markup()
    return markupsafe.Markup('aria-disabled="true" title="{0}" data-off="{0}"').format(reason)


def world(page: Page) -> str:
    """Return why the world cannot be controlled."""
    return page.world_off or ("" if page.studio.known.world else "No world is up.")


def training(page: Page) -> str:
    """Return why keys that only mean something in a training do nothing."""
    kept = page.training is not None
    if (why := page.agent_off) or page.is_training or kept:
        return why
    return f"{page.agent} trains nothing: press Train… above the field to begin."


def undoing(page: Page) -> str:
    """Return why nothing can be undone."""
    done = page.training.done if page.training is not None else ()
    return training(page) or ("" if done else "There is nothing to undo.")


def redoing(page: Page) -> str:
    """Return why nothing can be redone."""
    undone = page.training.undone if page.training is not None else ()
    return training(page) or ("" if undone else "There is nothing to redo.")


def testing(page: Page) -> str:
    """Return why what was learned cannot be tested, or saved."""
    learned = page.training
    if learned is not None and not any(e.state == START for e in learned.examples):
        return "There is nothing yet: command the behavior to begin with."
    return training(page)


def training_of(page: Page) -> Training:
    """Return the training of the page's agent.

    Raises:
        SwarmError: if there is none.
    """
    if page.training is None:
        raise SwarmError(nothing_in_training(page))
    return page.training


def nothing_in_training(page: Page) -> str:
    """Return why what concerns a training cannot be done without one."""
    if not page.agent:
        return CHOOSE_FIRST
    if page.is_training:  # its status arrives before its training
        return f"What {page.agent} trains is not known yet: try again in a moment."
    return f"{page.agent} is not training anything: begin a training."
