"""The first part of an exported Python file; it runs with Python 3.8 and without HiTAB."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

inf = math.inf
FLAGS = ("Done", "Failed")


class Action(NamedTuple):
    """A basic behavior to perform in this tick.

    ``started`` marks its beginning: stop the one before, even if it has the same name. If it
    is ``one_shot``, perform it only then. If it takes ``numbers`` and there are none, since no
    feature has a value, do nothing.
    """

    name: str
    arguments: tuple[str, ...] = ()
    one_shot: bool = False
    started: bool = False
    numbers: Mapping[str, float] = {}


class Numbers(NamedTuple):
    """The regression of a state's numbers: those of the three nearest moments shown."""

    axes: Any  # (feature, turn and radius of a circle, usual difference, categories)
    wanted: Any  # (name, low, high, on a circle)
    moments: Any  # (place, numbers)

    def at(self, values: Sequence[float]) -> dict[str, float]:
        """Return the numbers, given the values of the features."""
        if all(value != value for value in values):
            return {}
        place: list[tuple[float, int]] = []  # with how many coordinates the feature has
        for (_, turn, radius, usual, categories), value in zip(self.axes, values):  # noqa: B905
            if turn:
                angle = value * turn
                place += [(radius * math.cos(angle), 2), (radius * math.sin(angle), 2)]
            elif categories:
                known = value == value
                place += [
                    (math.sqrt(0.5) * (value == i) if known else value, categories)
                    for i in range(categories)
                ]
            else:
                place.append((value / usual, 1))
        near = sorted((_apart(place, at), number) for number, (at, _) in enumerate(self.moments))
        least = near[0][0]
        shown = [
            (least / away if least else float(not away), self.moments[number][1])
            for away, number in near[:3]
        ]
        whole = sum(weight for weight, _ in shown)
        return {
            name: _mean([(weight / whole, own[k]) for weight, own in shown], low, high, circular)
            for k, (name, low, high, circular) in enumerate(self.wanted)
        }


def _apart(place: list[tuple[float, int]], moment: Sequence[float]) -> float:
    pairs = zip(place, moment)  # noqa: B905
    return math.sqrt(sum((a - b) ** 2 if a == a and b == b else 1.0 / n for (a, n), b in pairs))


def _mean(shown: list[tuple[float, float]], low: float, high: float, circular: bool) -> float:
    if not circular:
        return min(max(sum(weight * value for weight, value in shown), low), high)
    turn = 2.0 * math.pi / (high - low)
    x = sum(weight * math.cos(value * turn) for weight, value in shown)
    y = sum(weight * math.sin(value * turn) for weight, value in shown)
    if math.hypot(x, y) < 1e-6:
        return shown[0][1]  # opposed directions have no mean
    return low + (math.atan2(y, x) / turn - low) % (high - low)


class State(NamedTuple):
    """A state: its `Action` or the name of its automaton, and its decision tree."""

    label: str
    performs: Any
    tree: Any
    numbers: Any = None


FEATURES: list[tuple[str, int, bool]] = []  # name, categories (-1: on a circle), required
AUTOMATA: dict[str, tuple[State, ...]] = {}
REQUIRED: dict[str, tuple[int, ...]] = {}  # features without which an automaton does nothing


class _Percept:
    """The feature values of a tick, followed by the inputs of decisions."""

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
        self.states, self.required = AUTOMATA[name], REQUIRED.get(name, ())
        self.state = 0
        self.entered = now
        self.seen = dict.fromkeys(FLAGS, now)
        self.raised: set[str] = set()
        self.child: _Performance | None = None

    def tick(self, percept: _Percept) -> Action | None:
        now = percept.now
        for feature in self.required:
            percept.read(*FEATURES[feature])
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
        shown = self.states[chosen].numbers
        if shown is not None:
            values = [self.value(axis[0], own, percept) for axis in shown.axes]
            performs = performs._replace(numbers=shown.at(values))
        return None if performs is None else performs._replace(started=started)

    def value(self, feature: int, own: list[float], percept: _Percept) -> float:
        if feature < len(own):
            return own[feature]
        return percept.read(*FEATURES[feature - len(own)])

    def decide(self, own: list[float], percept: _Percept) -> int:
        tree = self.states[self.state].tree
        if tree is None:
            return self.state
        node, drawn = tree[0], -1.0
        while len(node) == 7:
            feature, period, low, high, yes, no, share = node
            value = self.value(feature, own, percept)
            if period:
                value %= period
            if low < value <= high:
                node = tree[yes]
            elif value == value:
                node = tree[no]
            else:  # A missing value: draw, as often as examples went there.
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
