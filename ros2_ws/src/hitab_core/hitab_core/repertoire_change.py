"""An agent's repertoire changes in three steps: check everything, write to disk, swap.

This module is the first step. It changes nothing, so that writing may still fail afterwards, while
swapping cannot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from hitab_core.errors import LostBehaviorError, VocabularyError
from hitab_core.library.edition import Edition
from hitab_core.repertoire import Repertoire
from hitab_core.running.running_automaton import RunContext, Running
from hitab_core.training.training_session import TrainingSession
from hitab_core.use import Use


@dataclass(frozen=True)
class Prepared:
    """Everything an agent needs to switch to another repertoire.

    Attributes:
        edition: that the agent will switch to.
        context: that it will perform in.
        use: that it will perform; None: nothing, or the training.
        performance: of ``use``; not started.
    """

    edition: Edition
    context: RunContext
    use: Use | None
    performance: Running | None


def check_performable(repertoire: Repertoire, use: Use) -> None:
    """Check that a behavior can be the top-level one.

    Raises:
        VocabularyError: if there is no such behavior or target.
    """
    repertoire.get(use.name)
    repertoire.check_state(use)


def check_nothing_lost(before: Edition, after: Edition) -> None:
    """Check that no behavior of an edition would be lost with another one.

    Raises:
        LostBehaviorError: naming the ones that would be lost.
    """
    losses = after.losses
    gone = sorted(losses.reasons.keys() & before.files.keys())
    if gone:
        raise LostBehaviorError(
            f"{', '.join(gone)} would be lost: {'; '.join(losses.faults)}",
            *(remedy for name in gone for remedy in losses.remedies[name]),
        )


def check_change(
    context: RunContext, edition: Edition, use: Use | None, session: TrainingSession | None
) -> None:
    """Check that an agent can switch to another edition.

    Args:
        context: that it performs in now.
        edition: that the agent will switch to.
        use: that it will perform; None: nothing.
        session: its training, which will continue.

    Raises:
        VocabularyError: naming what does not fit, and the way out.
    """
    if use is not None:
        try:
            check_performable(edition.repertoire, use)
        except VocabularyError as error:
            raise VocabularyError(
                f'it could no longer perform "{use}": {error}; have it perform something else '
                "first, or nothing"
            ) from None
    if session is not None:
        try:
            session.check_on(replace(context, repertoire=edition.repertoire))
        except VocabularyError as error:
            raise VocabularyError(
                f'the training of "{session.curriculum.name}" could not continue: {error}; '
                "save it or discard it first"
            ) from None


def prepare(
    context: RunContext, edition: Edition, use: Use | None, session: TrainingSession | None
) -> Prepared:
    """Return what an agent needs to switch to another edition; see `check_change`.

    Raises:
        VocabularyError: naming what does not fit, and the way out.
    """
    check_change(context, edition, use, session)
    new = replace(context, repertoire=edition.repertoire)
    return Prepared(edition, new, use, None if use is None else new.perform(use))
