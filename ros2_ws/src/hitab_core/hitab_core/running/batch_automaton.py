"""One automaton performed by many agents at once, on arrays.

A tick does what `RunningAutomaton.tick` does for each agent, with the same comparisons and the
same draws of its own generator, but level by level: all agents in a state go down that state's
tree together. The result of a tick is which basic behavior each agent performs; the agents' own
bodies then perform it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Protocol

import numpy as np

from hitab_core.arrays import Booleans, Floats, Integers
from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.learning.compiled_tree import Compiled, Draw, drawn_from, ends
from hitab_core.learning.missing_values import Likely
from hitab_core.repertoire import Repertoire
from hitab_core.running.batch_senses import BatchSenses
from hitab_core.running.observing import guest
from hitab_core.running.own_columns import FLAG_BITS, OwnColumns
from hitab_core.running.running_automaton import Clock, Level
from hitab_core.transition_function import TransitionFunction, Values
from hitab_core.use import Use

NOTHING = -1
"""Marks an agent that performs no basic behavior."""

DrawFor = Callable[[Integers], Floats]
"""Returns a uniform number on [0, 1) for each row, from that agent's own generator."""

Observe = Callable[["BatchLevel", Integers, int, int], None]
"""Called for rows that change state, with the level and the source and destination indices."""


def draws_of(generators: Sequence[Callable[[], float]]) -> DrawFor:
    """Return a function that draws from the own generators of the given rows only."""
    return lambda rows: np.array([generators[row]() for row in rows.tolist()])


class _Decision(Protocol):
    """Decides for agents in one state; yields each next state with its rows."""

    def __call__(self, rows: Integers) -> Iterator[tuple[int, Integers]]:
        """Decide for some agents, leaving out those with unreadable features."""


class BatchLevel:
    """An automaton in the hierarchy, performed by the agents whose path leads to it.

    Attributes:
        label: of the automaton's use.
        path: labels of the automata from the top level to this one.
        labels: of its states, Start first.
        above: the parent level.
        active: shape (n,), index of each agent's active state; valid only for agents that perform
            this level.
        slots: of its features in the senses.
        own: the flags and timers of the agents' automata.
    """

    def __init__(
        self,
        batch: BatchAutomaton,
        automaton: Automaton,
        use: Use,
        above: BatchLevel | None,
    ) -> None:
        self.label = str(use)
        self.path: tuple[str, ...] = (*(above.path if above is not None else ()), self.label)
        self.automaton = automaton
        self.above = above
        self.bindings = dict(zip(automaton.parameters, use.arguments, strict=True))
        self.labels = [START, *automaton.labels]
        self.active: Integers = np.zeros(batch.size, np.int64)
        self.own = OwnColumns(batch.size, batch.senses)
        self._batch = batch
        self._bits = [FLAG_BITS.get(label, 0) for label in self.labels]
        self.children: list[BatchLevel | int | None] = [None]
        for state in automaton.states:
            self.children.append(
                None if state.name in FLAGS else batch.child(state.bound(self.bindings), self)
            )
        self.slots: list[int] = []
        for feature in automaton.features:
            slot = self.own.slot(feature)
            self.slots.append(
                batch.senses.slot(feature.bound(self.bindings)) if slot is None else slot
            )
        batch.timed |= self.own.timed
        index = {label: i for i, label in enumerate(self.labels)}
        self._decisions: list[_Decision | None] = [None] * len(self.labels)
        for label, function in automaton.transitions.items():
            self._decisions[index[label]] = batch.decision(function, self.slots, index)

    def start(self, rows: Integers) -> None:
        """Put some agents in Start, with no flag raised."""
        self.active[rows] = 0
        self.own.start(rows, self._batch.now)

    def tick(self, rows: Integers) -> None:
        """Let some agents query, change state and perform the active state."""
        active = self.active.take(rows)
        groups: list[tuple[int, Integers]] = []
        blank = []
        for state, count in enumerate(np.bincount(active).tolist()):
            if count:
                group = rows if count == len(rows) else rows[active == state]
                if self.children[state] is None:  # Start and flag states are left at once
                    blank.append(group)
                else:
                    groups.append((state, group))
        if blank:
            group = _joined(blank)
            self.active[group] = 0
            groups.append((0, group))
        gathered: list[list[Integers]] = [[] for _ in self.labels]
        for state, group in groups:
            if self.own.asked:
                child = self.children[state]
                below = child.own if isinstance(child, BatchLevel) else None
                self.own.query(below, group, self._batch.now, blank=child is None)
            decide = self._decisions[state]
            if decide is None:
                gathered[state].append(group)
                continue
            for chosen, piece in decide(group):
                if chosen != state:
                    self._enter(state, chosen, piece)
                gathered[chosen].append(piece)
        for chosen, pieces in enumerate(gathered):
            if pieces:
                self._perform(self.children[chosen], _joined(pieces))

    def _perform(self, child: BatchLevel | int | None, rows: Integers) -> None:
        if isinstance(child, BatchLevel):
            child.tick(rows)
        else:
            self._batch.arrive(rows, NOTHING if child is None else child)

    def _enter(self, source: int, chosen: int, rows: Integers) -> None:
        batch = self._batch
        if batch.observe is not None:
            batch.observe(self, rows, source, chosen)
        batch.leave(rows)
        self.active[rows] = chosen
        self.own.enter(rows, batch.now)
        child = self.children[chosen]
        if isinstance(child, BatchLevel):
            child.start(rows)
        elif child is None and chosen:
            self.own.raised[rows] |= self._bits[chosen]

    def active_path(self, row: int) -> list[str]:
        """Return the labels of one agent's active states, from this level inwards."""
        state = int(self.active[row])
        child = self.children[state]
        inner = child.active_path(row) if isinstance(child, BatchLevel) else []
        return [self.labels[state], *inner]

    def condition(self, row: int) -> list[Level]:
        """Return one agent's condition, from this level inwards."""
        state = int(self.active[row])
        child = self.children[state]
        inner = child.condition(row) if isinstance(child, BatchLevel) else []
        return [self.own.condition(row, state), *inner]

    def own_feature(self, use: Use, row: int) -> float:
        """Return the current value of one agent's flag or timer; leave flags up."""
        state = int(self.active[row])
        child = self.children[state]
        raised = child.own.raised_by(row) if isinstance(child, BatchLevel) else set()
        now = self._batch.time_of(row)
        return self.own.value(use, row, raised, now, blank=child is None)


class BatchAutomaton:
    """A behavior performed by n agents; see the module docstring.

    Compare `performed` before and after a tick: if an agent's entry changed, stop the old
    behavior, if any, and start the new one, if any. Then pulse the current one.

    Attributes:
        basics: the available basic behaviors, bound to targets.
        performed: shape (n,), index of each agent's basic behavior, or `NOTHING`.
        top: the top level.
        timed: whether any level has timers; only then is the time looked at.
        now: shape (n,), the agents' simulated time, s.
    """

    def __init__(
        self,
        repertoire: Repertoire,
        use: Use,
        senses: BatchSenses,
        draw: DrawFor,
        size: int,
        *,
        most_probable: bool = False,
        observe: Observe | None = None,
        clocks: Sequence[Clock] = (),
    ) -> None:
        """Put all agents in Start.

        Args:
            repertoire: the available behaviors.
            use: the automaton to perform; its arguments must be targets.
            senses: the agents' features; clear them before each tick.
            draw: random numbers for agents at a leaf with more than one state.
            size: number of agents, n.
            most_probable: take the most probable next state instead of drawing one.
            observe: called at each change of state, before the new state is started.
            clocks: of the agents; only needed for timers.
        """
        self.size = size
        self.timed = False
        self.now: Floats = np.zeros(size)
        self._clocks = clocks
        self.senses = senses
        self.observe = None if observe is None else guest(observe)
        self.basics: list[Use] = []
        self.performed: Integers = np.full(size, NOTHING, np.int64)
        self._repertoire = repertoire
        self._draw = draw
        self._most_probable = most_probable
        self._moved: Booleans = np.zeros(size, np.bool_)
        self._arrived: Booleans = np.zeros(size, np.bool_)
        top = self.child(use, None)
        if not isinstance(top, BatchLevel):
            raise TypeError(f'"{use}" is a basic behavior; only automata are performed in batches')
        self.top = top

    def start(self, rows: Integers) -> None:
        """Put some agents in Start; they perform nothing yet."""
        self._look_at_clocks()
        self.top.start(rows)
        self.performed[rows] = NOTHING

    def tick(self, rows: Integers) -> dict[int, Exception]:
        """Perform one timestep of some agents, each listed once.

        Returns:
            Feature errors by row. Such an agent keeps the state it had before the failed decision,
            and must not pulse.
        """
        self._moved[rows] = False
        self._arrived[rows] = False
        self._look_at_clocks()
        self.top.tick(rows)
        if not self.senses.errors:
            return {}
        lost = rows[~self._arrived[rows]]
        # An agent that left a state before a decision further inside failed performs nothing now.
        self.performed[lost[self._moved[lost]]] = NOTHING
        return {row: self.senses.errors[row] for row in lost.tolist()}

    def go_on_from(self, row: int, levels: Sequence[Level]) -> int:
        """Restore one agent's condition; return the index of what it performs."""
        child: BatchLevel | int | None = self.top
        for level in levels:
            assert isinstance(child, BatchLevel)
            child.active[row] = level.active
            child.own.go_on_from(row, level)
            child = child.children[level.active]
        performed = child if isinstance(child, int) else NOTHING
        self.performed[row] = performed
        return performed

    def active_path(self, row: int) -> list[str]:
        """Return the labels of one agent's active states, outermost first."""
        return self.top.active_path(row)

    def time_of(self, row: int) -> float:
        """Return one agent's simulated time, s."""
        return self._clocks[row].now

    def _look_at_clocks(self) -> None:
        if self.timed:
            self.now = np.array([clock.now for clock in self._clocks])

    # -- for the levels ---------------------------------------------------------------------

    def child(self, use: Use, above: BatchLevel | None) -> BatchLevel | int:
        """Return a new level for an automaton, or a basic behavior's index in `basics`."""
        behavior = self._repertoire.get(use.name)
        if isinstance(behavior, Automaton):
            return BatchLevel(self, behavior, use, above)
        self.basics.append(use)
        return len(self.basics) - 1

    def arrive(self, rows: Integers, basic: int) -> None:
        """Record the basic behavior at the end of some agents' paths."""
        self.performed[rows] = basic
        self._arrived[rows] = True

    def leave(self, rows: Integers) -> None:
        """Record that some agents have left a state."""
        self._moved[rows] = True

    def decision(
        self, function: TransitionFunction, slots: Sequence[int], states: dict[str, int]
    ) -> _Decision:
        """Return the decision of a transition function for many agents."""
        compile_batch = getattr(function, "compile_batch", None)
        if compile_batch is None:
            return self._one_by_one(function, slots, states)
        root, likely = compile_batch(slots, states, most_probable=self._most_probable)
        most_likely = None if likely is None else partial(self._likely, likely, _blank(slots))
        return partial(self._down_the_tree, root, most_likely)

    def _down_the_tree(
        self, root: Compiled, likely: Callable[[int], int | None] | None, rows: Integers
    ) -> Iterator[tuple[int, Integers]]:
        for ending in ends(root, self.senses, rows, self._draw, likely):
            leaf, piece, _ = ending
            if leaf is None:
                continue
            if not isinstance(leaf, Draw):
                yield leaf, piece
                continue
            drawn = drawn_from(leaf, ending, self._draw)
            for i, choice in enumerate(leaf.choices):
                chosen = piece[drawn == i]
                if len(chosen):
                    yield choice, chosen

    def _one_by_one(
        self, function: TransitionFunction, slots: Sequence[int], states: dict[str, int]
    ) -> _Decision:
        """Return the decision of a function that can decide only for one agent at a time."""
        decide_one = function.compile(slots, states, most_probable=self._most_probable)
        blank = _blank(slots)

        def decide(rows: Integers) -> Iterator[tuple[int, Integers]]:
            for row in rows.tolist():
                only = np.array([row])
                read, draw = partial(self._read, row), partial(self._draw_one, only)
                try:
                    chosen = decide_one(blank, read, draw)
                except Exception as error:  # one agent must not stop the others
                    self.senses.errors[row] = error
                    continue
                yield chosen, only

        return decide

    def _likely(self, likely: Likely, blank: Values, row: int) -> int | None:
        """Return the most probable state of an agent that lacks a value; None if it has none."""
        try:
            return likely(blank, partial(self._read, row))
        except Exception as error:  # one agent must not stop the others
            self.senses.errors[row] = error
            return None

    def _read(self, row: int, slot: int) -> float:
        return self.senses.value(slot, row)

    def _draw_one(self, only: Integers) -> float:
        return float(self._draw(only)[0])


def _blank(slots: Sequence[int]) -> Values:
    """Return values of which none has been read."""
    return [None] * (max(slots, default=0) + 1)


def _joined(pieces: list[Integers]) -> Integers:
    return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
