"""One demonstrator per agent at a time: who holds an agent, and how another takes it."""

from __future__ import annotations

from dataclasses import dataclass

from hitab_client import SwarmError


@dataclass(frozen=True)
class Holder:
    """Who holds an agent.

    Attributes:
        session: of the browser.
        name: of the demonstrator, for people.
    """

    session: str
    name: str


class Locks:
    """Who may command which agent. Commanding a free agent takes it."""

    def __init__(self) -> None:
        self._holders: dict[str, Holder] = {}

    def holder(self, agent: str) -> Holder | None:
        """Return who holds an agent."""
        return self._holders.get(agent)

    def claim(self, agent: str, holder: Holder) -> None:
        """Hold an agent, or keep holding it.

        Raises:
            SwarmError: if another demonstrator holds it.
        """
        other = self._holders.get(agent)
        if other is not None and other.session != holder.session:
            raise SwarmError(
                f"{agent} is being trained by {other.name}; press Take over this agent first"
            )
        self._holders[agent] = holder

    def take(self, agent: str, holder: Holder) -> Holder | None:
        """Take an agent; return its previous holder."""
        before = self._holders.get(agent)
        self._holders[agent] = holder
        return before if before is not None and before.session != holder.session else None

    def release(self, agent: str, session: str) -> None:
        """Release an agent."""
        holder = self._holders.get(agent)
        if holder is not None and holder.session == session:
            del self._holders[agent]

    def leave(self, session: str) -> None:
        """Release all agents: the browser has gone."""
        for agent in [a for a, h in self._holders.items() if h.session == session]:
            del self._holders[agent]

    def clear(self) -> None:
        """Release all agents: they have gone."""
        self._holders.clear()
