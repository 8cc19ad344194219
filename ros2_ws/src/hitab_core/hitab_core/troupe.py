"""Many agents that perform the same behavior, decided for together and acting each by itself.

A member of a troupe stands where an agent's own `RunningAutomaton` would stand, and does the same
with the agent's body. Whoever has the percepts of all calls `Troupe.decide` first; the members'
ticks then only carry out what was decided.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hitab_core.automaton import Automaton
from hitab_core.batch_automaton import NOTHING, BatchAutomaton, BatchLevel, draws_of
from hitab_core.batch_senses import BatchSenses
from hitab_core.gain_ratio import Booleans, Integers
from hitab_core.observing import Change
from hitab_core.running_automaton import Condition, RunningBasicBehavior, Stage
from hitab_core.use import Use


class Troupe:
    """Agents that perform the same automaton with the same repertoire.

    Attributes:
        members: by row; each is to be started before it is ticked.
        batch: what decides for them.
    """

    def __init__(self, stages: Sequence[Stage], use: Use, percepts: Any = None) -> None:
        """Make a member for each agent.

        Args:
            stages: of the agents, which share a repertoire and how states are chosen.
            use: the automaton to perform, its arguments targets.
            percepts: see `BatchSenses`; whoever calls `decide` keeps it up to date.
        """
        first = stages[0]
        self.stages = tuple(stages)
        self.senses = BatchSenses(
            first.repertoire.domain, len(stages), [stage.body for stage in stages], percepts
        )
        self.batch = BatchAutomaton(
            first.repertoire,
            use,
            self.senses,
            draws_of([stage.draw for stage in stages]),
            len(stages),
            most_probable=first.most_probable,
            observe=self._observe if any(stage.observe for stage in stages) else None,
        )
        self.decided: Booleans = np.zeros(len(stages), np.bool_)
        self.errors: dict[int, Exception] = {}
        self.members = [TroupeMember(self, row) for row in range(len(stages))]

    def forget(self) -> None:
        """Forget all feature values: new percepts have come."""
        self.senses.forget()

    def decide(self, rows: Integers) -> None:
        """Decide what some members do in this timestep, on percepts that their bodies have."""
        for row in rows.tolist() if self.errors else ():
            self.errors.pop(row, None)
        self.errors |= self.batch.tick(rows)
        self.decided[rows] = True

    def decide_alone(self, only: Integers) -> None:
        """Decide for one member by what its own body perceives."""
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
    """The flags of a member, which are taken down where they are kept."""

    def __init__(self, level: BatchLevel, row: int) -> None:
        super().__init__(level.raised_by(row))
        self._level = level
        self._row = row

    def clear(self) -> None:
        """Take down all flags."""
        super().clear()
        self._level.raised[self._row] = 0


class TroupeMember:
    """One agent's part in a troupe: a `hitab_core.running_automaton.Running`."""

    __slots__ = ("_basics", "_only", "_performed", "_row", "_troupe")

    def __init__(self, troupe: Troupe, row: int) -> None:
        self._troupe = troupe
        self._row = row
        self._only: Integers = np.array([row])
        self._performed = NOTHING
        self._basics: dict[int, RunningBasicBehavior] = {}

    @property
    def raised(self) -> set[str]:
        """The flags that the behavior has raised."""
        return _Raised(self._troupe.batch.top, self._row)

    @property
    def outermost(self) -> LevelOfMember:
        """The automaton that is performed."""
        return LevelOfMember(self._troupe.batch.top, self._row)

    @property
    def active_path(self) -> list[str]:
        """The active states from the behavior's own inwards."""
        return self._troupe.batch.active_path(self._row)

    def condition(self) -> Condition:
        """Return where it is; see `RunningAutomaton.condition`."""
        performed = self._performed
        basic = None if performed == NOTHING else self._basic(performed)
        return self._troupe.batch.top.condition(self._row), basic

    def go_on_from(self, condition: Condition) -> None:
        """Be where something else that performs the same was."""
        levels, basic = condition
        performed = self._troupe.batch.go_on_from(self._row, levels)
        self._performed = performed
        if basic is not None:
            self._basics[performed] = basic

    def start(self) -> None:
        """Begin in Start, with no flag raised."""
        self._troupe.batch.start(self._only)
        self._troupe.decided[self._row] = False
        self._performed = NOTHING

    def stop(self) -> None:
        """Stop what is performed and fall back to Start."""
        if self._performed != NOTHING:
            self._basic(self._performed).stop()
        self.start()

    def tick(self) -> None:
        """Carry out what was decided for this timestep; decide now if that was not done.

        Raises:
            FeatureValueError: if a feature that the decision needed had no value.
        """
        troupe, row = self._troupe, self._row
        if not troupe.decided[row]:
            troupe.decide_alone(self._only)
        troupe.decided[row] = False
        performed, before = int(troupe.batch.performed[row]), self._performed
        self._performed = performed
        if performed != before:
            if before != NOTHING:
                self._basic(before).stop()
            if performed != NOTHING:
                self._basic(performed).start()
        if row in troupe.errors:
            raise troupe.errors.pop(row)
        if performed != NOTHING:
            self._basic(performed).tick()

    def _basic(self, index: int) -> RunningBasicBehavior:
        basic = self._basics.get(index)
        if basic is None:
            made = self._troupe.stages[self._row].perform(self._troupe.batch.basics[index])
            assert isinstance(made, RunningBasicBehavior)
            basic = self._basics[index] = made
        return basic


class LevelOfMember:
    """One agent's automaton in a troupe, as those look at it who ask what the agent perceives."""

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
        return self._level.raised_by(self._row)

    @property
    def child(self) -> LevelOfMember | None:
        """What its active state performs, if that is an automaton."""
        child = self._level.children[int(self._level.active[self._row])]
        return LevelOfMember(child, self._row) if isinstance(child, BatchLevel) else None
