"""Reasons for which buttons of the page are unavailable; "" if available."""

from __future__ import annotations

from jinja2.utils import markupsafe

from hitab_client import SwarmError, Training
from hitab_core import START
from hitab_studio.pages.page import CHOOSE_FIRST, Page


def off(reason: str) -> markupsafe.Markup:
    """Return the attributes of an unavailable button, which shows the reason when pressed.

    Unlike a disabled button, an unavailable one can be reached with the keyboard. Place the
    attributes before ``title``.
    """
    if not reason:
        return markupsafe.Markup()
    return markupsafe.Markup('aria-disabled="true" title="{0}" data-off="{0}"').format(reason)


def world(page: Page) -> str:
    """Return the reason for which the world cannot be controlled."""
    return page.world_off or ("" if page.studio.known.world else "No world is up.")


def going_back(page: Page) -> str:
    """Return the reason for which the world cannot be put back to the shown moment."""
    past, status = page.time.past, page.studio.known.world
    if why := world(page):
        return why
    if past is None or status is None:
        return "Go back first: drag on the strip, or press the comma key."
    if not status.oldest:
        return f"The world {status.world} cannot go back: start a new episode instead (R)."
    if past.at < status.oldest:
        return f"The world can go back to cycle {status.oldest} at most: choose a later moment."
    return ""


def showing(page: Page, cycle: int) -> str:
    """Return the reason for which the situation of a cycle cannot be shown."""
    if page.studio.known.robots is not None:
        return "Robots have no common cycle: find the moment on the strip."
    minute = page.studio.link.minute
    return "" if minute.begin <= cycle <= minute.now else "That was more than a minute ago."


def freezing(page: Page) -> str:
    """Return the reason for which a key cannot freeze the world."""
    status = page.studio.known.world
    if (why := world(page)) or status is None:
        return why
    return "" if status.pace == status.REALTIME else "In lockstep the world does not wait for you."


def training(page: Page) -> str:
    """Return the reason for which keys of a training are unavailable."""
    if (why := page.agent_off) or page.is_training or page.training is not None:
        return why
    return nothing_in_training(page)


def undoing(page: Page) -> str:
    """Return the reason for which nothing can be undone."""
    done = page.training.done if page.training is not None else ()
    return training(page) or ("" if done else "There is nothing to undo.")


def redoing(page: Page) -> str:
    """Return the reason for which nothing can be redone."""
    undone = page.training.undone if page.training is not None else ()
    return training(page) or ("" if undone else "There is nothing to redo.")


def testing(page: Page) -> str:
    """Return the reason for which the trained behavior cannot be tested or saved."""
    learned = page.training
    if learned is not None and not any(e.state == START for e in learned.examples):
        return "Nothing is learned yet: command the first behavior."
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
    """Return the error of a request that needs a training, while there is none."""
    if not page.agent:
        return CHOOSE_FIRST
    if page.is_training:  # its status arrives before its training
        return f"The training of {page.agent} is not known yet: try again in a moment."
    return f"{page.agent} is not being trained: press Train… above the field."
