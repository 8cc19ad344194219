"""Lockstep: which agents of a world are present, and have answered the percepts of a round."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

Answer = tuple[Sequence[float], str]


class RoundAnswers:
    """Records the answers to one round of percepts.

    An agent that misses a deadline is not waited for until it answers again: a dead agent must not
    slow down the others for longer than one deadline. All are waited for in the first round played
    after rounds of looking, so that a run without one of the agents has a missed deadline.
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
        self._joined = joined
        self._silent: set[str] = set()
        self._awaited: set[str] = set()
        self._sequence = 0
        self._looked = True

    @property
    def missing(self) -> list[str]:
        """The agents that no node answers for."""
        return [name for name in self.agents if name not in self.present or name in self._silent]

    @property
    def silent(self) -> bool:
        """Whether an agent is present but not waited for."""
        return bool(self._silent)

    @property
    def complete(self) -> bool:
        """Whether no agent is waited for in this round."""
        return not self._awaited

    @property
    def late(self) -> list[str]:
        """The agents that are waited for in this round."""
        return sorted(self._awaited)

    def look(self) -> bool:
        """Update which agents are present; return whether that has changed."""
        present = {name for name in self.agents if self._joined(name)}
        changed = present != self.present
        self._silent -= self.present - present  # one that returns starts over
        self.present = present
        return changed

    def begin(self, sequence: int, *, look: bool = False) -> None:
        """Begin a round, in which the agents may only ``look``: forget the previous answers."""
        self._sequence = sequence
        self.answers = {}
        if self._looked and not look:
            self._silent = set()
        self._looked = look
        if self._silent >= self.present:
            # All of them were late, so something held them up, such as a commander. By now they
            # no longer wait for it.
            self._silent = set()
        self._awaited = self.present - self._silent

    def excuse(self, agent: str) -> None:
        """Do not wait for an agent in this round: it has nothing to answer."""
        self._awaited.discard(agent)

    def take(self, agent: str, sequence: int, answer: Answer) -> None:
        """Take an agent's answer; one to an earlier round only shows that the agent is alive."""
        if agent not in self._known:
            return
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
        """Do not wait for the agents that have not answered until they do."""
        self._silent |= self._awaited
        self._awaited = set()
