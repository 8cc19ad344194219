"""Deciding in one batch for the agents of a host that perform the same automaton."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np

from hitab_core import Agent, BatchPercepts, WhenUnsure, action_behaviors
from hitab_core.running import AgentBatch, BatchMember, Running, RunningAutomaton

WORTH_IT = 8
"""Below this number of agents, ticking them one by one is as fast."""


class _Cast:
    """A batch with the agents that are its members, by row."""

    def __init__(self, agents: Sequence[Agent]) -> None:
        first = agents[0]
        assert first.top is not None
        self._digest = first.library_digest
        self.agents = tuple(agents)
        self.percepts = BatchPercepts(np.zeros((len(agents), 0)))
        self.batch = AgentBatch([agent.context for agent in agents], first.top, self.percepts)
        for agent, member in zip(agents, self.batch.members, strict=True):
            performance = agent.performance
            assert isinstance(performance, RunningAutomaton | BatchMember)
            member.go_on_from(performance.condition())
            agent.hand_over(member)

    @property
    def is_current(self) -> bool:
        """Whether any member still has the library that this was made from."""
        return any(agent.library_digest == self._digest for agent in self.agents)

    def has(self, agents: Sequence[Agent]) -> bool:
        """Whether these agents are members."""
        members = dict(zip(self.agents, self.batch.members, strict=True))
        return all(members.get(agent) is agent.performance for agent in agents)

    def decide(self, row_of: dict[Agent, int], values: Any, heard: dict[int, list[str]]) -> None:
        """Decide for the members that are in a batch of percepts."""
        batch, percepts = self.batch, self.percepts
        present = [
            (row, row_of[agent])
            for row, agent in enumerate(self.agents)
            if agent in row_of and agent.performance is batch.members[row]
        ]
        if not present:
            return
        rows = np.array([row for row, _ in present])
        if percepts.values.shape[1] != values.shape[1]:
            percepts.values = np.zeros((len(self.agents), values.shape[1]))
        percepts.values[rows] = values[[place for _, place in present]]
        percepts.heard = {row: heard[place] for row, place in present if place in heard}
        batch.forget()
        batch.decide(rows)


class AgentBatches:
    """Groups the agents that perform the same, and regroups them when that changes."""

    def __init__(self) -> None:
        self._known: dict[Agent, Running | None] = {}
        self._casts: dict[Hashable, _Cast] = {}

    def decide(self, agents: Sequence[Agent], values: Any, heard: dict[int, list[str]]) -> None:
        """Decide for the agents where a batch pays off; the others decide when they are ticked.

        Args:
            agents: those that have received percepts.
            values: their percepts, shape (n, m); None if their layouts differ.
            heard: the messages heard, by position among the agents.
        """
        known = self._known
        if any(known.get(agent, self) is not agent.performance for agent in agents):
            self._cast_anew(agents)
        if values is None:
            return
        row_of = {agent: place for place, agent in enumerate(agents)}
        for cast in self._casts.values():
            cast.decide(row_of, values, heard)

    def _cast_anew(self, agents: Sequence[Agent]) -> None:
        groups: dict[Hashable, list[Agent]] = {}
        for agent in agents:
            # In a batch, basic behaviors raise no flags, as actions do.
            alone = agent.monitor.caution.when_unsure is not WhenUnsure.GO_ON
            alone = alone or bool(action_behaviors(agent.domain))
            if not alone and isinstance(agent.performance, RunningAutomaton | BatchMember):
                groups.setdefault(_same(agent), []).append(agent)
        for same, alike in groups.items():
            cast = self._casts.get(same)
            if len(alike) >= WORTH_IT and (cast is None or not cast.has(alike)):
                self._casts[same] = _Cast(alike)
        self._known = {agent: agent.performance for agent in agents}
        # A batch made from a library that no agent has any longer is never used again.
        self._casts = {same: cast for same, cast in self._casts.items() if cast.is_current}


def _same(agent: Agent) -> Hashable:
    """Return a key that is equal for agents that can share a batch."""
    context = agent.context
    digest = agent.library_digest, context.repertoire.domain.signature
    return str(agent.top), digest, context.most_probable
