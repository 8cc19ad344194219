"""What an exported Python file begins with; it runs with Python 3.8 and without HiTAB."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

inf = math.inf
FLAGS = ("Done", "Failed")


class Action(NamedTuple):
    """A basic behavior to perform in this tick.

    ``started`` says that it begins now: stop the one before, even if it has the same name. If it
    is ``one_shot``, perform it only then.
    """

    name: str
    arguments: tuple[str, ...] = ()
    one_shot: bool = False
    started: bool = False


class State(NamedTuple):
    """What a state performs, an `Action` or the name of an automaton, and its decision tree."""

    label: str
    performs: Any
    tree: Any


FEATURES: list[tuple[str, int, bool]] = []  # name, categories (-1: on a circle), required
AUTOMATA: dict[str, tuple[State, ...]] = {}


class _Percept:
    """Feature values of one tick, followed by the inputs of its decisions."""

    def __init__(
        self, values: Mapping[str, float | None], now: float, draw: Callable[[], float]
    ) -> None:
        self.values, self.now, self.draw = values, now, draw

    def read(self, name: str, categories: int, required: bool) -> float:
        given = self.values.get(name)
        value = math.nan if given is None else float(given)
        if value != value:
            if required:
                raise ValueError(f"{name} has no value, and nothing is decided without it")
        elif categories < 0 and math.isinf(value):
            raise ValueError(f"{name} has value {value}, not on its circle")
        elif categories > 0 and not (0 <= value < categories and value == int(value)):
            raise ValueError(f"{name} has value {value}, not one of its categories")
        return value


class _Performance:
    """An automaton being performed; a new one for each entry."""

    def __init__(self, name: str, now: float) -> None:
        self.states = AUTOMATA[name]
        self.state = 0
        self.entered = now
        self.seen = dict.fromkeys(FLAGS, now)
        self.raised: set[str] = set()
        self.child: _Performance | None = None

    def tick(self, percept: _Percept) -> Action | None:
        now = percept.now
        if self.states[self.state].performs is None:
            self.state = 0  # Start and flag states are left at once
        own = [0.0, 0.0, max(0.0, now - self.entered) if self.state else 0.0]
        if self.child is not None and self.child.raised:
            own[:2] = [float(flag in self.child.raised) for flag in FLAGS]
            self.seen.update(dict.fromkeys(self.child.raised, now))
            self.child.raised.clear()
        own += [max(0.0, now - self.seen[flag]) for flag in FLAGS]
        chosen = self.decide(own, percept)
        started = chosen != self.state
        performs = self.states[chosen].performs
        if started:
            self.state, self.entered, self.child = chosen, now, None
            if isinstance(performs, str):
                self.child = _Performance(performs, now)
            elif performs is None:
                self.raised.add(self.states[chosen].label)
        if self.child is not None:
            return self.child.tick(percept)
        return None if performs is None else performs._replace(started=started)

    def decide(self, own: list[float], percept: _Percept) -> int:
        tree = self.states[self.state].tree
        if tree is None:
            return self.state
        node, drawn = tree[0], -1.0
        while len(node) == 7:
            feature, period, low, high, yes, no, share = node
            own_feature = feature < len(own)
            value = own[feature] if own_feature else percept.read(*FEATURES[feature - len(own)])
            if period:
                value %= period
            if low < value <= high:
                node = tree[yes]
            elif value == value:
                node = tree[no]
            else:  # It is missing: draw, as often as examples went there.
                drawn = percept.draw() if drawn < 0.0 else drawn
                if drawn < share:
                    node, drawn = tree[yes], drawn / share
                else:
                    node, drawn = tree[no], min((drawn - share) / (1.0 - share), 1.0 - 2.0**-53)
        below, states = node
        if len(states) == 1:
            return int(states[0])
        drawn = percept.draw() if drawn < 0.0 else drawn
        return int(states[bisect_right(below, drawn)])


class Behavior:
    """A learned behavior, performed by one robot."""

    NAME = ""

    def __init__(self) -> None:
        self._top: _Performance | None = None

    def start(self, now: float) -> None:
        """Begin anew; the first tick does so by itself."""
        self._top = _Performance(self.NAME, now)

    def tick(
        self, percept: Mapping[str, float | None], now: float, draw: Callable[[], float]
    ) -> Action | None:
        """Return the basic behavior to perform, or None: stop the one before, and do nothing.

        Args:
            percept: feature values by name; None, NaN or no entry where there is no value.
            now: seconds on a clock that never goes back.
            draw: returns a random number from [0, 1); see `random.random`.

        Raises:
            ValueError: naming a feature whose value is impossible, or missing but required.
        """
        if self._top is None:
            self.start(now)
        assert self._top is not None
        return self._top.tick(_Percept(percept, now, draw))

    @property
    def path(self) -> list[str]:
        """The active states, the outermost first."""
        level, found = self._top, []
        while level is not None:
            found.append(level.states[level.state].label)
            level = level.child
        return found

    @property
    def raised(self) -> set[str]:
        """The flags, Done and Failed, that the behavior has raised; clear them once seen."""
        return set() if self._top is None else self._top.raised
