"""Many agents that perform the same behavior: decided together, acting individually.

A member of a batch replaces the agent's own `RunningAutomaton`. Call `AgentBatch.decide` first,
with all percepts; the members' ticks then carry out the decisions on the agents' bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hitab_core.arrays import Booleans, Integers
from hitab_core.automaton import Automaton
from hitab_core.running.batch_automaton import NOTHING, BatchAutomaton, BatchLevel, draws_of
from hitab_core.running.batch_senses import BatchSenses
from hitab_core.running.observing import Change
from hitab_core.running.running_automaton import Condition, RunContext
from hitab_core.running.running_basic import RunningBasicBehavior
from hitab_core.use import Use


class AgentBatch:
    """Agents that perform the same automaton with the same repertoire.

    Attributes:
        members: by row; start each before its first tick.
        batch: that decides for them.
    """

    def __init__(self, stages: Sequence[RunContext], use: Use, percepts: Any = None) -> None:
        """Make a member for each agent.

        Args:
            stages: of the agents; they must share a repertoire and ``most_probable``.
            use: the automaton to perform; its arguments must be targets.
            percepts: see `BatchSenses`; the caller of `decide` keeps it up to date.
        """
        first = stages[0]
        self.stages = tuple(stages)
        self.senses = BatchSenses(
            first.repertoire.domain, len(stages), [context.body for context in stages], percepts
        )
        self.batch = BatchAutomaton(
            first.repertoire,
            use,
            self.senses,
            draws_of([context.draw for context in stages]),
            len(stages),
            most_probable=first.most_probable,
            observe=self._observe if any(context.observe for context in stages) else None,
            clocks=[context.clock for context in stages],
        )
        self.decided: Booleans = np.zeros(len(stages), np.bool_)
        self.errors: dict[int, Exception] = {}
        self.members = [BatchMember(self, row) for row in range(len(stages))]

    def forget(self) -> None:
        """Clear all feature values, for new percepts."""
        self.senses.forget()

    def decide(self, rows: Integers) -> None:
        """Decide for some members in this timestep, from the percepts in their bodies."""
        for row in rows.tolist() if self.errors else ():
            self.errors.pop(row, None)
        self.errors |= self.batch.tick(rows)
        for row, missed in self.senses.missed.items():
            self.stages[row].senses.missed.update(missed)
        self.decided[rows] = True

    def decide_alone(self, only: Integers) -> None:
        """Decide for one member from its own body's percept."""
        self.senses.forget()
        self.senses.from_bodies = True
        self.decide(only)
        self.senses.from_bodies = False
        self.senses.forget()

    def _observe(self, level: BatchLevel, rows: Integers, source: int, chosen: int) -> None:
        labels, automaton, known = level.labels, level.automaton, self.senses.known
        for row in rows.tolist():
            observe = self.stages[row].observe
            if observe is not None:
                change = Change(
                    level.path,
                    labels[source],
                    labels[chosen],
                    False,
                    automaton.features,
                    level.bindings,
                    [known(slot, row) for slot in level.slots],
                    automaton.transitions.get(labels[source]),
                )
                observe(change)


class _Raised(set[str]):
    """The flags of a member; clearing them clears the batch's copy."""

    def __init__(self, level: BatchLevel, row: int) -> None:
        super().__init__(level.own.raised_by(row))
        self._level = level
        self._row = row

    def clear(self) -> None:
        """Lower all flags."""
        super().clear()
        self._level.own.raised[self._row] = 0


class BatchMember:
    """One agent's part in a batch: a `hitab_core.running.running_automaton.Running`."""

    __slots__ = ("_basics", "_batch", "_only", "_performed", "_row")

    def __init__(self, batch: AgentBatch, row: int) -> None:
        self._batch = batch
        self._row = row
        self._only: Integers = np.array([row])
        self._performed = NOTHING
        self._basics: dict[int, RunningBasicBehavior] = {}

    @property
    def raised(self) -> set[str]:
        """The flags that the behavior has raised."""
        return _Raised(self._batch.batch.top, self._row)

    @property
    def outermost(self) -> LevelOfMember:
        """The automaton being performed."""
        return LevelOfMember(self._batch.batch.top, self._row)

    @property
    def active_path(self) -> list[str]:
        """The active states, outermost first."""
        return self._batch.batch.active_path(self._row)

    def condition(self) -> Condition:
        """Return its current condition; see `RunningAutomaton.condition`."""
        performed = self._performed
        basic = None if performed == NOTHING else self._basic(performed)
        return self._batch.batch.top.condition(self._row), basic

    def go_on_from(self, condition: Condition) -> None:
        """Continue from the condition of another performance of the same behavior."""
        levels, basic = condition
        performed = self._batch.batch.go_on_from(self._row, levels)
        self._performed = performed
        if basic is not None:
            self._basics[performed] = basic

    def start(self) -> None:
        """Begin in Start, with no flag raised."""
        self._batch.batch.start(self._only)
        self._batch.decided[self._row] = False
        self._performed = NOTHING

    def stop(self) -> None:
        """Stop the active state and return to Start."""
        if self._performed != NOTHING:
            self._basic(self._performed).stop()
        self.start()

    def tick(self) -> None:
        """Carry out the decision for this timestep; decide now if there is none yet.

        Raises:
            FeatureValueError: if a feature that the decision needed had no value.
        """
        batch, row = self._batch, self._row
        if not batch.decided[row]:
            batch.decide_alone(self._only)
        batch.decided[row] = False
        performed, before = int(batch.batch.performed[row]), self._performed
        self._performed = performed
        if performed != before:
            if before != NOTHING:
                self._basic(before).stop()
            if performed != NOTHING:
                self._basic(performed).start()
        if row in batch.errors:
            raise batch.errors.pop(row)
        if performed != NOTHING:
            self._basic(performed).tick()

    def _basic(self, index: int) -> RunningBasicBehavior:
        basic = self._basics.get(index)
        if basic is None:
            made = self._batch.stages[self._row].perform(self._batch.batch.basics[index])
            assert isinstance(made, RunningBasicBehavior)
            basic = self._basics[index] = made
        return basic


class LevelOfMember:
    """One agent's automaton in a batch, as `live_features` inspects it."""

    def __init__(self, level: BatchLevel, row: int) -> None:
        self._level = level
        self._row = row

    @property
    def automaton(self) -> Automaton:
        """The automaton."""
        return self._level.automaton

    @property
    def bindings(self) -> dict[str, str]:
        """What its parameters are bound to."""
        return self._level.bindings

    @property
    def label(self) -> str:
        """How it is used."""
        return self._level.label

    @property
    def raised(self) -> set[str]:
        """The flags that it has raised."""
        return self._level.own.raised_by(self._row)

    def own_feature(self, use: Use) -> float:
        """Return the current value of a flag or timer; see `RunningAutomaton.own_feature`."""
        return self._level.own_feature(use, self._row)

    @property
    def child(self) -> LevelOfMember | None:
        """The automaton of its active state; None if that is not an automaton."""
        child = self._level.children[int(self._level.active[self._row])]
        return LevelOfMember(child, self._row) if isinstance(child, BatchLevel) else None
