"""Events of a training; assistants may subscribe.

An assistant sees percepts, commands and changes. It may propose when a command was due, and is
otherwise a guest: its exceptions do not propagate (`hitab_core.running.observing.guest`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, NamedTuple, ParamSpec, TypeVar

from hitab_core.example import Example
from hitab_core.running.observing import guest
from hitab_core.texts.errors import TrainingError
from hitab_core.training.percepts import PerceptRecord

P = ParamSpec("P")
T = TypeVar("T")

PACE_MAX = 1000.0
"""No person watches a world that is faster."""


@dataclass(frozen=True)
class Given:
    """The circumstances of a command: who gives it, and when it was due.

    Attributes:
        cycle: the world's cycle, stored with the examples.
        seen: the world's cycle that the demonstrator saw; 0 for the last one.
        pace: simulated seconds that pass for the demonstrator in a second; 0 if the situation
            has waited.
        exact: whether the command is meant for the percept seen; else an assistant may estimate
            how late it comes.
        who: name of the demonstrator; empty if unknown.
    """

    cycle: int = 0
    seen: int = 0
    pace: float = 0.0
    exact: bool = False
    who: str = ""

    def check(self) -> None:
        """Check that a world can have this pace.

        Raises:
            TrainingError: if not.
        """
        if not 0.0 <= self.pace <= PACE_MAX:
            raise TrainingError(
                f"the pace of the world cannot be {self.pace:g} simulated seconds in a second; "
                f"give a number from 0 (it waits) to {PACE_MAX:g}"
            )


NOW = Given()
"""A command that is due now, by an unknown demonstrator."""


@dataclass(frozen=True)
class CommandGiven:
    """A command that is about to be recorded.

    Attributes:
        label: label of the commanded state.
        given: who gives the command, and when it was due.
        taken_over_in: label of the state in which the person took over to give it; empty if the
            automaton had not decided.
        stated: function that returns the percept for which it is due by the person's statement.
    """

    label: str
    given: Given
    taken_over_in: str
    stated: Callable[[], PerceptRecord]


class Proposal(NamedTuple):
    """An assistant's estimate of when a command was due.

    Attributes:
        due: the percept.
        settled: earlier examples, changed in the light of this command.
        record: fields of the journal's record, so that a replay needs no assistant.
    """

    due: PerceptRecord
    settled: Sequence[Example] = ()
    record: Mapping[str, Any] = {}


class Event(Generic[P, T]):
    """Something that happens in a training."""

    def __init__(self) -> None:
        self._hear: list[Callable[P, T | None]] = []

    def subscribe(self, hear: Callable[P, T | None]) -> None:
        """Call a function whenever it happens."""
        self._hear.append(guest(hear))

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> T | None:
        """Call all subscribers; return the first answer, if there is one."""
        first: T | None = None
        for hear in self._hear:
            answer = hear(*args, **kwargs)
            first = answer if first is None else first
        return first


@dataclass(frozen=True)
class TrainingEvents:
    """The events of one training.

    Attributes:
        perceived: a percept.
        begun: the percept in which a state is entered other than by a decision or command;
            None if there was none.
        commanded: a command, before it is recorded; the answer says when it was due.
        changed: a step of the training, as the journal keeps it; also when it is resumed.
        decided: the label of the state that is active after a tick of the learned automaton.
        episode: another episode begins.
        back: the world goes back to a cycle, and plays again from there.
        interrupted: the label of the state in which the person or something else intervened.
    """

    perceived: Event[[PerceptRecord], None] = field(default_factory=Event)
    begun: Event[[PerceptRecord | None], None] = field(default_factory=Event)
    commanded: Event[[CommandGiven], Proposal] = field(default_factory=Event)
    changed: Event[[Mapping[str, Any]], None] = field(default_factory=Event)
    decided: Event[[str], None] = field(default_factory=Event)
    episode: Event[[], None] = field(default_factory=Event)
    back: Event[[int], None] = field(default_factory=Event)
    interrupted: Event[[str], None] = field(default_factory=Event)
