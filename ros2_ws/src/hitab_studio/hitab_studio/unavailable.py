"""Why something on the page does nothing at present; empty if it does something."""

from __future__ import annotations

from jinja2.utils import markupsafe

from hitab_core import START
from hitab_ros import names
from hitab_studio.absence import absence
from hitab_studio.page import CHOOSE_FIRST, REAL, Page

RECORDING = "This is a recording: close it first (Esc)."


def off(reason: str) -> markupsafe.Markup:
    """Return the attributes of a button that does nothing at present and says why when pressed.

    It can be reached with the keyboard, unlike a disabled one. Place them before ``title``.
    """
    if not reason:
        return markupsafe.Markup()
    return markupsafe.Markup('aria-disabled="true" title="{0}" data-off="{0}"').format(reason)


def world(page: Page) -> str:
    """Return why the world cannot be controlled."""
    known = page.shared.store.known
    if page.player is not None:
        return RECORDING
    if known.robots is not None:
        return REAL
    if known.world is None:
        return "No world is up."
    if absent := absence(known, names.WORLD):
        return f"The world {absent.what}."
    return page.shared.generations.why_busy


def agent(page: Page) -> str:
    """Return why the agent cannot be commanded."""
    name, known = page.agent, page.shared.store.known
    if page.player is not None:
        return RECORDING
    if not name:
        return CHOOSE_FIRST
    if absent := absence(known, name):
        return f"{name} {absent.what}."
    if page.locked:
        return f"{page.shared.held[name].name} holds {name}: take it over first."
    return page.shared.generations.why_busy


def training(page: Page) -> str:
    """Return why keys that only mean something in a training do nothing."""
    kept = page.training is not None
    if (why := agent(page)) or page.is_training or kept:
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
