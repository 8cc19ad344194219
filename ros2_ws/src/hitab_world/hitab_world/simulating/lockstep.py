"""The answers of a lockstep round: which agents are present, and which have answered."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

Answer = tuple[Sequence[float], str]


class Take(Protocol):
    """Interface of what takes an agent's answer; see `RoundAnswers.take`."""

    def __call__(
        self, agent: str, sequence: int, answer: Answer, *, taught: bool = False, hold: str = ""
    ) -> None:
        """Take an answer."""


class RoundAnswers:
    """Records the answers to one round of percepts.

    A world does not wait for an agent that missed a deadline until the agent answers again: a dead
    agent must not slow down the others for longer than one deadline. In the first round after
    look-only ones, the world waits for all agents, so that a run without one of them has a missed
    deadline.

    Attributes:
        holds: why agents want the world to hold before they act, by name.
        taught: the agents that a demonstrator is in control of, as their last answers say.
    """

    def __init__(self, agents: Iterable[str], joined: Callable[[str], bool]) -> None:
        """Start with no agent present.

        Args:
            agents: all agents of the world.
            joined: returns whether a node listens to an agent's percepts.
        """
        self.agents = tuple(agents)
        self._known = frozenset(self.agents)
        self.present: set[str] = set()
        self.answers: dict[str, Answer] = {}
        self.missed_deadlines = 0
        self.holds: dict[str, str] = {}
        self.taught: set[str] = set()
        self._joined = joined
        self._silent: set[str] = set()
        self._awaited: set[str] = set()
        self._sequence = self._last_look = 0
        self._last_was_look = True

    @property
    def missing(self) -> list[str]:
        """The agents for which no node answers."""
        return [name for name in self.agents if name not in self.present or name in self._silent]

    @property
    def silent(self) -> bool:
        """Whether an agent is present but missed a deadline, and has not answered since."""
        return bool(self._silent)

    @property
    def complete(self) -> bool:
        """Whether all agents that are waited for in this round have answered."""
        return not self._awaited

    @property
    def late(self) -> list[str]:
        """The agents that are waited for in this round."""
        return sorted(self._awaited)

    def look(self) -> bool:
        """Update which agents are present; return whether that has changed."""
        present = {name for name in self.agents if self._joined(name)}
        changed = present != self.present
        self._silent -= self.present - present  # an agent that returns is awaited again
        self.taught &= present
        self.present = present
        return changed

    def begin(self, sequence: int, *, look: bool = False) -> None:
        """Begin a round and forget the previous answers; ``look`` marks a look-only round."""
        self._sequence = sequence
        self.answers, self.holds = {}, {}
        if look:
            self._last_look = sequence
        if self._last_was_look and not look:
            self._silent = set()
        self._last_was_look = look
        if self._silent >= self.present:
            # All of them were late, so they had a common cause, such as a commander that they
            # waited for. By now they no longer wait for it.
            self._silent = set()
        self._awaited = self.present - self._silent

    def excuse(self, agent: str) -> None:
        """Do not wait for an agent in this round, since it got no percept."""
        self._awaited.discard(agent)

    def take(
        self, agent: str, sequence: int, answer: Answer, *, taught: bool = False, hold: str = ""
    ) -> None:
        """Take an agent's answer; one to an earlier round only shows that the agent is alive.

        Args:
            agent: its name.
            sequence: number of the round.
            answer: its action and message.
            taught: whether a demonstrator is in control of it.
            hold: why it wants the world to hold before it acts; it has not acted then, so that a
                late answer counts, too, unless the world has stood still since.
        """
        if agent not in self._known:
            return
        if taught:
            self.taught.add(agent)
        else:
            self.taught.discard(agent)
        if hold and sequence > self._last_look:
            self.holds[agent] = hold
        self._silent.discard(agent)
        if sequence == self._sequence:
            self.answers[agent] = answer
            self._awaited.discard(agent)

    def count_late(self, *, exclude: bool) -> list[str]:
        """Count and return the agents that have not answered; ``exclude`` gives up on them."""
        late = self.late
        self.missed_deadlines += len(late)
        if exclude:
            self.give_up_on_late()
        return late

    def give_up_on_late(self) -> None:
        """No longer wait for the agents that have not answered, until they answer."""
        self._silent |= self._awaited
        self._awaited = set()
