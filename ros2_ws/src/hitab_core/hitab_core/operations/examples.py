"""Operations on the examples of a training, and answers to its questions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hitab_core.term import Term
from hitab_core.texts.wording import quantity
from hitab_core.training.operation import Operation, Outcome

if TYPE_CHECKING:
    from hitab_core.agent import Agent
    from hitab_core.training_session import TrainingSession


@dataclass(frozen=True)
class Undo(Operation):
    """Undo the last command, deletion or other edit.

    Undoing a command makes the agent perform its previous behavior again.
    """

    def apply(self, agent: Agent) -> Outcome:
        """Undo."""
        session = agent.under_way()
        session.undo()
        return _edited(session, f"undone: {session.log.history.undone[0]}")


@dataclass(frozen=True)
class Redo(Operation):
    """Redo what was undone last, if nothing else was done since."""

    def apply(self, agent: Agent) -> Outcome:
        """Redo."""
        session = agent.under_way()
        session.redo()
        return _edited(session, f"redone: {session.log.history.done[-1]}")


@dataclass(frozen=True)
class DeleteExamples(Operation):
    """Delete examples; undoing brings them back.

    Attributes:
        numbers: numbers of the examples.
    """

    numbers: Sequence[int]

    def apply(self, agent: Agent) -> Outcome:
        """Delete the examples."""
        session = agent.under_way()
        session.delete(self.numbers)
        return _edited(session)


@dataclass(frozen=True)
class RelabelExamples(Operation):
    """Change the next state of examples; undoing reverts this.

    Attributes:
        numbers: numbers of the examples.
        next_state: the right next state, with its targets and numbers, if any.
    """

    numbers: Sequence[int]
    next_state: str

    def apply(self, agent: Agent) -> Outcome:
        """Change the examples."""
        session = agent.under_way()
        session.relabel(self.numbers, Term.parse(self.next_state))
        return _edited(session)


@dataclass(frozen=True)
class RetimeExamples(Operation):
    """Correct late commands: date them back to an earlier percept of the agent.

    Attributes:
        numbers: numbers of examples; of a command all are retimed.
        ago: time from the situation to the command, s of simulated time.
    """

    numbers: Sequence[int]
    ago: float

    def apply(self, agent: Agent) -> Outcome:
        """Change the examples."""
        session = agent.under_way()
        session.retime(self.numbers, self.ago)
        return _edited(session)


@dataclass(frozen=True)
class ChooseFeatures(Operation):
    """Learn from other features of the same examples.

    Attributes:
        features: all that examples will have, such as ``"DistanceTo(ball)"``.
    """

    features: Sequence[str]

    def apply(self, agent: Agent) -> Outcome:
        """Choose the features."""
        session = agent.under_way()
        session.choose_features(list(map(Term.parse, self.features)))
        return _edited(session)


@dataclass(frozen=True)
class AnswerQuestion(Operation):
    """Answer a question of the agent.

    Attributes:
        number: number of the question.
        choice: one of its choices; empty for the proposed one.
        dismiss: do not ask this again; nothing changes.
    """

    number: int
    choice: str = ""
    dismiss: bool = False

    def apply(self, agent: Agent) -> Outcome:
        """Change the examples as the answer says."""
        session = agent.under_way()
        session.answer(self.number, self.choice, dismiss=self.dismiss)
        if self.dismiss:
            return Outcome(f"question {self.number} is not asked again")
        return Outcome(f"question {self.number}: {_last_edit(session)}")


def _edited(session: TrainingSession, done: str = "") -> Outcome:
    count = quantity(len(session.log), "example")
    return Outcome(f'{done or _last_edit(session)}; "{session.curriculum.name}" has {count}')


def _last_edit(session: TrainingSession) -> str:
    return (session.log.history.done or ["nothing"])[-1]
