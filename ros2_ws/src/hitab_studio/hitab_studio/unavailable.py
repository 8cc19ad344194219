"""Why something on the page does nothing at present; empty: it does something."""

from __future__ import annotations

from jinja2.utils import markupsafe

from hitab_core import START, Example
from hitab_ros import names
from hitab_studio.absence import absence
from hitab_studio.session import CHOOSE_FIRST, REAL, Session, nothing_in_training

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
    if absent := absence(known, names.WORLD):
        return f"The world {absent}."
    return session.shared.generations.why_busy


def agent(session: Session) -> str:
    """Return why the agent cannot be commanded."""
    name, known = session.agent, session.shared.store.known
    if session.player is not None:
        return RECORDING
    if not name:
        return CHOOSE_FIRST
    if absent := absence(known, name):
        return f"{name} {absent}."
    if session.locked:
        return f"{session.shared.held[name].name} holds {name}: take it over first."
    return session.shared.generations.why_busy


def commanding(session: Session) -> str:
    """Return why a key for a behavior does nothing."""
    return "" if session.agent else agent(session)


def raising(session: Session) -> str:
    """Return why a key for a flag does nothing."""
    if session.status is not None and session.status.mode in ("training", "testing"):
        return ""
    return (
        agent(session) or f"{session.agent} is not training anything; only a training has flags."
    )


def undoing(session: Session) -> str:
    """Return why nothing can be undone."""
    training = session.watched.training
    if not training.done if training is not None else not _examples(session):
        return _without_training(session) or (
            "There is nothing to undo: no command and no edit was made yet."
        )
    return agent(session)


def redoing(session: Session) -> str:
    """Return why nothing can be redone."""
    training = session.watched.training
    if training is None or not training.undone:
        return _without_training(session) or (
            "There is nothing to redo: nothing was undone, or something else was done since."
        )
    return agent(session)


def retiming(session: Session) -> str:
    """Return why no command can have been due earlier."""
    training = session.watched.training
    if not _examples(session) or (training is not None and not training.examples):
        return _without_training(session) or (
            "There is no command yet that could have been due earlier."
        )
    return last_standing_still(session) or agent(session)


def _without_training(session: Session) -> str:
    known = session.is_training or session.watched.training is not None
    return nothing_in_training(session) if session.agent and not known else ""


def last_standing_still(session: Session) -> str:
    """Return why the last command was not late, if the world stood still when it was given."""
    training = session.watched.training
    if training is None or not training.examples:
        return ""
    last = max(training.examples, key=lambda e: (e.command, -e.number))
    return standing_still(session, last)


def standing_still(session: Session, example: Example) -> str:
    """Return why an example cannot be due earlier, if the world stood still at its command."""
    training, moments = session.watched.training, session.shared.store.known.moments
    if training is None or not moments.stood_still(
        session.agent, training.name, example.number, example.cycle
    ):
        return ""
    return (
        "The command was given while the world stood still, so it was not late. If it was wrong, "
        "undo it (U), or delete its examples."
    )


def testing(session: Session) -> str:
    """Return why what was learned cannot be tested."""
    training = session.watched.training
    begun = training is not None and any(e.state == START for e in training.examples)
    if not begun and (training is not None or not _examples(session)):
        return "There is nothing to test yet: command the behavior that it should begin with."
    return agent(session)


def switching(session: Session) -> str:
    """Return why nobody can switch between training and testing."""
    why = agent(session)
    kept = session.watched.training is not None
    if why or session.is_training or kept or session.status is None:
        return why
    learned = ""
    if session.watched.vocabulary.trained:
        learned = " To see what it has learned before, press Perform in Teach."
    return (
        f"{session.agent} trains nothing, so there is nothing to test (T). Press Train… above the "
        f"field to begin.{learned}"
    )


def _examples(session: Session) -> int:
    """Return the number of examples by the status, which is known before what they are."""
    return session.status.examples if session.status is not None else 0


def saving(session: Session) -> str:
    """Return why a training cannot be saved."""
    if not _examples(session):
        return "There is nothing to save yet: no example was recorded."
    return testing(session)
