"""The features of many agents as columns, read when a decision first needs them.

A feature that its domain can read for all agents at once (`Feature.read_all`) costs one array
operation; any other is read agent by agent, only where a decision needs it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from hitab_core.arrays import Booleans, Floats, Integers
from hitab_core.domain import Domain
from hitab_core.errors import NoValueError
from hitab_core.running.senses import ON_CIRCLE, checked, checks_of, resolved
from hitab_core.use import Use

ReadAll = Callable[[], Floats]


@dataclass(slots=True)
class _Column:
    """The values of one feature: shape (n,).

    Attributes:
        checks: of a value, see `checked`.
        use: of the feature.
        readers: functions that read it from an agent's body, by row; made on first use.
        known: which values have been read since the last percepts.
        whole: whether all values are known.
        wrong: why a value is missing or impossible, by row; such values are NaN.
    """

    values: Floats
    checks: tuple[str, int, bool] = ("", 0, False)
    read_all: ReadAll | None = None
    use: Use | None = None
    readers: dict[int, Callable[[], float]] = field(default_factory=dict)
    known: Booleans | None = None
    whole: bool = False
    wrong: dict[int, Exception] = field(default_factory=dict)


class BatchSenses:
    """Feature values of many agents by slot, as in `Senses` for one agent.

    Attributes:
        from_bodies: whether to read everything from bodies, agent by agent.
        errors: why a feature without which nothing is decided could not be read, by row.
        missed: why a feature that a decision needed had no value, by row and feature.
    """

    def __init__(
        self, domain: Domain, size: int, bodies: Sequence[Any] = (), percepts: Any = None
    ) -> None:
        """Set up senses for the agents.

        Args:
            domain: of the features.
            size: number of agents, n.
            bodies: of the agents; not needed for features that are read for all at once.
            percepts: passed to `Feature.read_all`; None: read every feature agent by agent.
        """
        self.from_bodies = False
        self.errors: dict[int, Exception] = {}
        self.missed: dict[int, dict[Use, str]] = {}
        self._domain = domain
        self._size = size
        self._bodies = bodies
        self._percepts = percepts
        self._columns: list[_Column] = []
        self._slots: dict[Use, int] = {}

    def slot(self, use: Use) -> int:
        """Return the slot of a feature bound to targets, making it on first use."""
        if use not in self._slots:
            feature = self._domain.features[use.name]
            column = _Column(
                np.zeros(self._size), checks_of(use, feature), self._reads_all(use), use
            )
            self._columns.append(column)
            self._slots[use] = len(self._columns) - 1
        return self._slots[use]

    def _reads_all(self, use: Use) -> ReadAll | None:
        domain = self._domain
        read = domain.features[use.name].read_all
        resolvers = [domain.targets[argument].resolve_all for argument in use.arguments]
        if self._percepts is None or read is None or None in resolvers:
            return None
        percepts = self._percepts
        return lambda: read(percepts, *[r(percepts) for r in resolvers if r is not None])

    def own_slot(self) -> int:
        """Return a new slot that the automaton fills itself."""
        self._columns.append(_Column(np.zeros(self._size), whole=True))
        return len(self._columns) - 1

    def put(self, slot: int, rows: Integers, values: Any) -> None:
        """Set values in an automaton's own slot."""
        self._columns[slot].values[rows] = values

    def forget(self) -> None:
        """Clear all values except the automata's own, for new percepts."""
        self.errors.clear()
        self.missed.clear()
        for slot in self._slots.values():
            column = self._columns[slot]
            column.whole = False
            column.wrong.clear()
            column.known = None

    def take(self, slot: int, rows: Integers) -> tuple[Floats, Booleans | None]:
        """Return the values of some agents; see `compiled_tree.Columns`."""
        column = self._columns[slot]
        if not column.whole and not self._read_all(column):
            self._read(column, rows)
        values = column.values.take(rows)
        if not column.wrong:
            return values, None
        without = np.zeros(len(rows), np.bool_)
        for place in np.flatnonzero(values != values).tolist():
            without[place] = self._miss(column, int(rows[place]))
        return values, without

    def _miss(self, column: _Column, row: int) -> bool:
        """Note that a value was needed and not there; return whether one may decide without it."""
        error = column.wrong[row]
        if not isinstance(error, NoValueError):
            self.errors[row] = error
            return False
        assert column.use is not None
        self.missed.setdefault(row, {})[column.use] = str(error)
        return True

    def value(self, slot: int, row: int) -> float:
        """Return one value.

        Raises:
            NoValueError: if the feature has no value now.
            FeatureValueError: if it has none and no decision may do without.
        """
        values, without = self.take(slot, np.array([row]))
        if without is not None and values[0] != values[0]:
            raise self._columns[slot].wrong[row]
        return float(values[0])

    def known(self, slot: int, row: int) -> float | None:
        """Return a value if it has been read since the last percepts, else None.

        NaN if it was read and missing.
        """
        column = self._columns[slot]
        if not (column.whole or (column.known is not None and column.known[row])):
            return None
        if row in column.wrong:
            return math.nan if isinstance(column.wrong[row], NoValueError) else None
        return float(column.values[row])

    def _read_all(self, column: _Column) -> bool:
        """Read a column for all agents at once; return whether that is possible."""
        if column.read_all is None or self.from_bodies or column.known is not None:
            return False
        try:
            # A copy, since single values are written into it.
            values = np.array(column.read_all(), np.float64)
            if values.shape != (self._size,):
                raise ValueError(f"shape {values.shape}, not {(self._size,)}")
        except Exception:  # domain code: reading one by one finds the agent and the reason
            return False
        column.values = values
        self._inspect(column)
        return True

    def _inspect(self, column: _Column) -> None:
        """Find impossible values in a complete column."""
        column.whole = True
        values = column.values
        wrong = values != values
        _, categories, _ = column.checks
        if categories > 0:
            wrong |= ~((values >= 0) & (values < categories) & (values == np.floor(values)))
        elif categories == ON_CIRCLE:
            wrong |= np.isinf(values)
        for row in np.flatnonzero(wrong).tolist():
            self._read_one(column, row, partial(float, values[row]))

    def _read(self, column: _Column, rows: Integers) -> None:
        if column.known is None:
            column.known = np.zeros(self._size, np.bool_)
        for row in rows[~column.known[rows]].tolist():
            self._read_one(column, row, self._reader(column, row))
        column.known[rows] = True

    def _reader(self, column: _Column, row: int) -> Callable[[], float]:
        reader = column.readers.get(row)
        if reader is None:
            assert column.use is not None
            read = self._domain.features[column.use.name].read
            reader = resolved(read, self._bodies[row], self._domain, column.use)
            column.readers[row] = reader
        return reader

    def _read_one(self, column: _Column, row: int, read: Callable[[], float]) -> None:
        try:
            column.values[row] = checked(read, *column.checks)
        except Exception as error:  # one agent's sensor must not stop the others
            column.values[row] = np.nan
            column.wrong[row] = error
