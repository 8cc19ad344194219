"""What operations are about: a behavior with its targets, and the training of an agent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hitab_core.term import Term
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.remedies import Fix

if TYPE_CHECKING:
    from hitab_core.agent import Agent
    from hitab_core.training_session import TrainingSession


def term_of(behavior: str, targets: Sequence[str]) -> Term:
    """Return a behavior with its targets, which may be part of the name, as in ``GoTo(ball)``."""
    term = Term.parse(behavior)
    return Term(term.name, (*term.arguments, *targets))


def training_of(agent: Agent) -> TrainingSession:
    """Return an agent's training under way.

    Raises:
        TrainingError: if there is none.
    """
    if agent.session is None:
        ways = Fix.RESUME(agent=agent.name), Fix.TRAIN(agent=agent.name)
        raise TrainingError("it is not training anything", *ways)
    return agent.session
