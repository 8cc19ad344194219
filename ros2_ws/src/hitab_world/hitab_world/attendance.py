"""Who among the agents of a world is there, and who has answered in this round."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

Answer = tuple[Sequence[float], str]


class Attendance:
    """Keeps account of the answers to one round of percepts.

    An agent that lets a deadline pass is not waited for any more until it answers again: a dead
    one must not slow the others down for longer than one deadline.
    """

    def __init__(self, agents: Iterable[str], joined: Callable[[str], bool]) -> None:
        """Know who may come.

        Args:
            agents: all that the world has a place for.
            joined: tells whether a node listens to an agent's percepts.
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

    @property
    def missing(self) -> list[str]:
        """The agents that no node answers for."""
        return [name for name in self.agents if name not in self.present or name in self._silent]

    @property
    def silent(self) -> bool:
        """Whether somebody is there but not waited for."""
        return bool(self._silent)

    @property
    def complete(self) -> bool:
        """Whether nobody is waited for in this round."""
        return not self._awaited

    def look(self) -> bool:
        """Find out who is there; return whether that has changed."""
        present = {name for name in self.agents if self._joined(name)}
        changed = present != self.present
        self._silent -= self.present - present  # whoever comes back begins anew
        self.present = present
        return changed

    def begin(self, sequence: int) -> None:
        """Begin a round: forget the answers to the last one."""
        self._sequence = sequence
        self.answers = {}
        if self._silent >= self.present:
            # What all of them have waited for in vain, such as a commander, they have given up.
            self._silent = set()
        self._awaited = self.present - self._silent

    def excuse(self, agent: str) -> None:
        """Do not wait for an agent in this round: there is nothing that it could answer."""
        self._awaited.discard(agent)

    def take(self, agent: str, sequence: int, answer: Answer) -> None:
        """Take an agent's answer; one to an earlier round only tells that the agent is alive."""
        if agent not in self._known:
            return
        self._silent.discard(agent)
        if sequence == self._sequence:
            self.answers[agent] = answer
            self._awaited.discard(agent)

    def count_late(self, *, exclude: bool) -> list[str]:
        """Count those who have not answered; with ``exclude`` do not wait for them again."""
        late = sorted(self._awaited)
        self.missed_deadlines += len(late)
        if exclude:
            self.give_up_on_late()
        return late

    def give_up_on_late(self) -> None:
        """Do not wait for those who have not answered until they do."""
        self._silent |= self._awaited
        self._awaited = set()
