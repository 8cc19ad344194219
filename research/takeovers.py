"""DAgger with takeovers: a peer learns while it plays, corrected by a demonstrator.

The peer's policy plays. A teacher watches one agent with a clear intention of its own; where the
policy does something else, the teacher takes over, commands what it would do, plays on itself for
a moment and lets go. Each takeover is one command, from which the policy is learned again at once
(Ross, Gordon and Bagnell, 2011; Kelly and others, 2019, with a human's takeovers).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

from peers import Command, Learner, Policy

from hitab_core import START, Automaton, HandWritten, Term

HOLD_CYCLES = 10
"""How long a teacher plays after a takeover: a person does not give ten commands a second."""


class Teacher(Protocol):
    """A demonstrator's intention."""

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode."""

    def wants(self, readings: Sequence[float]) -> str:
        """Return the basic behavior to be performed now; ``"Start"``: none. Once a cycle."""


@dataclass
class Takeovers:
    """The commands that a teacher gives, and the policy that is learned from them.

    Attributes:
        learn: learns a policy.
        behaviors: all that may be commanded.
        budget: number of commands.
        commands: given so far.
        policy: learned from these; None before the first.
    """

    learn: Learner
    behaviors: Sequence[str]
    budget: int
    commands: list[Command] = field(default_factory=list)
    policy: Policy | None = None
    _left: int = 0

    @property
    def over(self) -> bool:
        """Whether all commands have been given."""
        return len(self.commands) >= self.budget

    def pupil(self, name: str, features: Sequence[Term], teacher: Teacher | None) -> Automaton:
        """Return an automaton that performs the policy as it is at any time.

        Args:
            name: of the automaton.
            features: all that can be read.
            teacher: who watches and corrects it; None: nobody does.
        """
        every = tuple(range(len(features)))

        def of(state: str) -> HandWritten:
            chosen = (
                partial(self._alone, state)
                if teacher is None
                else partial(self._watched, teacher, state)
            )
            return HandWritten(chosen, every)

        return Automaton(
            name,
            tuple(Term.parse(behavior) for behavior in self.behaviors),
            tuple(features),
            {state: of(state) for state in (START, *self.behaviors)},
        )

    def begin(self) -> None:
        """Begin an episode: nobody has taken over."""
        self._left = 0

    def _alone(self, state: str, *readings: float) -> str:
        return state if self.policy is None else self.policy(readings, state)

    def _watched(self, teacher: Teacher, state: str, *readings: float) -> str:
        wanted = teacher.wants(readings)
        if wanted == START:
            return self._alone(state, *readings)
        if self._left:
            self._left -= 1
            return wanted
        own = self._alone(state, *readings)
        if own == wanted or self.over:
            return own
        self.commands.append(Command(tuple(readings), state, wanted))
        self.policy = self.learn(self.commands)
        self._left = HOLD_CYCLES
        return wanted
