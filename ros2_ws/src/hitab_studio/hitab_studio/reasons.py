"""Why something on the page does nothing at present; empty: it does something."""

from __future__ import annotations

from jinja2.utils import markupsafe

from hitab_core import START, quantity
from hitab_ros import names
from hitab_studio.session import REAL, Session

RECORDING = "This is a recording: close it first (Esc)."


def off(reason: str) -> markupsafe.Markup:
    """Return the attributes of a button that does nothing at present and says why when pressed.

    It can be reached with the keyboard, unlike a disabled one. Place them before ``title``.
    """
    if not reason:
        return markupsafe.Markup()
    return markupsafe.Markup('aria-disabled="true" title="{0}" data-off="{0}"').format(reason)


def world(session: Session) -> str:
    """Return why the world cannot be controlled."""
    known = session.shared.store.known
    if session.player is not None:
        return RECORDING
    if known.robots is not None:
        return REAL
    if known.world is None:
        return "No world is up."
    if names.WORLD in known.silent:
        return "The world does not respond."
    return session.shared.generations.why_busy


def agent(session: Session) -> str:
    """Return why the agent cannot be commanded."""
    name, known = session.agent, session.shared.store.known
    if session.player is not None:
        return RECORDING
    if not name:
        return "Choose an agent first, in the list or in the field."
    if not known.answers(name):
        return f"{name} {absence(session, name)}."
    holder = session.shared.locks.holder(name)
    if holder is not None and holder.session != session.id:
        return f"{holder.name} holds {name}: take it over first."
    return session.shared.generations.why_busy


def absence(session: Session, name: str) -> str:
    """Say how an agent, or the world, is absent; empty if it answers."""
    known = session.shared.store.known
    if name in known.gone:
        return "has ended"
    if name in known.silent:
        return f"has not responded for {quantity(session.seconds_since(name), 'second')}"
    if name == names.WORLD or name in known.statuses:
        return ""
    if name not in known.agents:
        return "is not up"
    return "has not been heard yet" if known.is_waiting else "does not answer"


def undoing(session: Session) -> str:
    """Return why nothing can be undone."""
    watched = session.watched
    known = watched.training is not None or not _examples(session)
    if known and not watched.history.done:
        return "There is nothing to undo: no command and no edit was made yet."
    return agent(session)


def redoing(session: Session) -> str:
    """Return why nothing can be redone."""
    if not session.watched.history.undone:
        return "There is nothing to redo: nothing was undone, or something else was done since."
    return agent(session)


def retiming(session: Session) -> str:
    """Return why no command can have been due earlier."""
    training = session.watched.training
    if not _examples(session) or (training is not None and not training.examples):
        return "There is no command yet that could have been due earlier."
    scene, given = session.shared.store.known.scene, training.examples if training else ()
    if scene is not None and scene.mode == "paused" and given:
        last = max(given, key=lambda e: (e.command, -e.number))
        if last.cycle >= scene.cycle:
            return (
                "The world stood still when you gave the last command, so the command was not "
                "late. If it was wrong, undo it (U)."
            )
    return agent(session)


def testing(session: Session) -> str:
    """Return why what was learned cannot be tested."""
    training = session.watched.training
    begun = training is not None and any(e.state == START for e in training.examples)
    if not begun and (training is not None or not _examples(session)):
        return "There is nothing to test yet: command the behavior that it should begin with."
    return agent(session)


def _examples(session: Session) -> int:
    """Return the number of examples by the status, which is known before what they are."""
    return session.status.examples if session.status is not None else 0


def saving(session: Session) -> str:
    """Return why a training cannot be saved."""
    if not _examples(session):
        return "There is nothing to save yet: no example was recorded."
    return testing(session)
