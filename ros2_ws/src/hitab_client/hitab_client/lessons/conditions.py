"""Conditions of a lesson, in terms of what a person sees.

    {distance: [keeper_1, ball], below: 4}          m; `above` likewise
    {bearing: [keeper_1, ball], above: 10}          degrees off keeper_1's heading
    {speed: ball, below: 0.5}                       m/s
    {feature: "DistanceTo(ball)", below: 4}         as the agent perceives it, in its unit
    {active: GotoBall, agent: keeper_1}             keeper_1's active states contain GotoBall
    {said: keeper_2}                                keeper_2 has yelled
    {ended: taken}                                  an episode has ended this way, or in `any` way
    {seconds: 1.5}                                  simulated seconds have passed
    {all: [...]}  {any: [...]}  {not: ...}

Instead of a second name, ``closest taker`` (or another kind) means the one closest to the first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from hitab_client.world_view import WorldView
from hitab_core import quantity
from hitab_core.library import Fields


class Condition(Protocol):
    """A condition that can be evaluated and described."""

    def holds(self, view: WorldView) -> bool:
        """Whether it holds in this view."""

    def describe(self, view: WorldView | None = None) -> str:
        """Return it in words, with the current value if a view is given."""


@dataclass(frozen=True)
class Comparison:
    """A distance, bearing or speed above or below a limit."""

    what: str
    things: tuple[str, ...]
    below: float | None
    above: float | None

    def value(self, view: WorldView) -> float:
        """Return the value to compare."""
        figure: float = getattr(view, self.what)(*self.things)
        return figure

    def holds(self, view: WorldView) -> bool:
        """Whether the value lies within the limits."""
        value = self.value(view)
        return (self.below is None or value < self.below) and (
            self.above is None or value > self.above
        )

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``distance of keeper_1 and ball below 4 (is 5.2)``."""
        limits = [f"below {self.below:g}"] if self.below is not None else []
        limits += [f"above {self.above:g}"] if self.above is not None else []
        seen = f" (is {self.value(view):.2f})" if view is not None else ""
        return f"{self.what} of {' and '.join(self.things)} {' and '.join(limits)}{seen}"


@dataclass(frozen=True)
class Perceived:
    """A feature of an agent above or below a limit."""

    feature: str
    agent: str
    below: float | None
    above: float | None

    def holds(self, view: WorldView) -> bool:
        """Whether the value lies within the limits; no value does not."""
        value = view.reading(self.agent, self.feature)
        return (
            value == value
            and (self.below is None or value < self.below)
            and (self.above is None or value > self.above)
        )

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``DistanceTo(ball) of keeper_1 below 4 (is 5.20)``."""
        limits = [f"below {self.below:g}"] if self.below is not None else []
        limits += [f"above {self.above:g}"] if self.above is not None else []
        seen = ""
        if view is not None:
            value = view.reading(self.agent, self.feature)
            seen = f" (is {value:.2f})" if value == value else " (has no value)"
        return f"{self.feature} of {self.agent} {' and '.join(limits)}{seen}"


@dataclass(frozen=True)
class Active:
    """A state among an agent's active states, with or without its targets."""

    state: str
    agent: str

    def holds(self, view: WorldView) -> bool:
        """Whether the agent performs it, at any level."""
        path = (view.paths or {}).get(self.agent, ())
        return any(label == self.state or label.split("(")[0] == self.state for label in path)

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``keeper_1 in GotoBall``."""
        seen = ""
        if view is not None:
            path = (view.paths or {}).get(self.agent, ())
            seen = f" (is in {' > '.join(path) if path else 'nothing'})"
        return f"{self.agent} in {self.state}{seen}"


@dataclass(frozen=True)
class Said:
    """An agent has said something since the step began."""

    by: str

    def holds(self, view: WorldView) -> bool:
        """Whether it has."""
        return self.by in view.said

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``keeper_2 has said something``."""
        return f"{self.by} has said something"


@dataclass(frozen=True)
class Ended:
    """An episode has ended since the step began; ``any``: in any way."""

    how: str

    def holds(self, view: WorldView) -> bool:
        """Whether one has."""
        return bool(view.ended) if self.how == "any" else self.how in view.ended

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``the episode has ended (taken)``."""
        return "the episode has ended" + ("" if self.how == "any" else f" ({self.how})")


@dataclass(frozen=True)
class Passed:
    """Simulated time has passed since the step began."""

    seconds: float

    def holds(self, view: WorldView) -> bool:
        """Whether it has, with half a millisecond of tolerance."""
        return view.seconds >= self.seconds - 5e-4

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``1.5 s have passed``."""
        return f"{self.seconds:g} s have passed"


@dataclass(frozen=True)
class Combination:
    """All or any of some conditions, or the opposite of one."""

    how: str
    parts: tuple[Condition, ...]

    def holds(self, view: WorldView) -> bool:
        """Whether the combination holds."""
        held = [part.holds(view) for part in self.parts]
        if self.how == "not":
            return not held[0]
        return all(held) if self.how == "all" else any(held)

    def describe(self, view: WorldView | None = None) -> str:
        """Return the parts, joined."""
        parts = [part.describe(view) for part in self.parts]
        if self.how == "not":
            return f"not ({parts[0]})"
        return (" and " if self.how == "all" else " or ").join(parts)


def parse_condition(fields: Fields, agent: str) -> Condition:
    """Read a condition; ``agent`` is the default where none is named."""
    for key, parse in _KINDS.items():
        if key in fields:
            condition = parse(fields, key, agent)
            fields.done()
            return condition
    fields.complain(f"a condition needs one of: {', '.join(_KINDS)}")
    return Passed(0.0)


def _comparison(fields: Fields, key: str, agent: str) -> Condition:
    things = fields.texts(key)
    wanted = 1 if key == "speed" else 2
    if len(things) != wanted:
        example = "ball" if wanted == 1 else "[keeper_1, ball]"
        fields.complain(f"`{key}:` needs {quantity(wanted, 'thing')}, such as {example}", key)
        things = ("?",) * wanted
    below, above = fields.number("below", None), fields.number("above", None)
    if below is None and above is None:
        fields.complain(f"`{key}:` needs `below:` or `above:`", key)
    return Comparison(key, tuple(things), below, above)


def _perceived(fields: Fields, key: str, agent: str) -> Condition:
    below, above = fields.number("below", None), fields.number("above", None)
    if below is None and above is None:
        fields.complain(f"`{key}:` needs `below:` or `above:`", key)
    feature = fields.text(key) or ""
    return Perceived(feature, fields.text("agent", agent), below, above)


def _active(fields: Fields, key: str, agent: str) -> Condition:
    return Active(fields.text(key) or "", fields.text("agent", agent))


def _said(fields: Fields, key: str, agent: str) -> Condition:
    return Said(fields.text(key) or "")


def _ended(fields: Fields, key: str, agent: str) -> Condition:
    return Ended(fields.text(key) or "any")


def _passed(fields: Fields, key: str, agent: str) -> Condition:
    return Passed(fields.number(key) or 0.0)


def _several(fields: Fields, key: str, agent: str) -> Condition:
    parts = tuple(parse_condition(part, agent) for part in fields.each(key))
    if not parts:
        fields.complain(f"`{key}:` needs a list of conditions", key)
    return Combination(key, parts)


def _opposite(fields: Fields, key: str, agent: str) -> Condition:
    return Combination(key, (parse_condition(fields.inner(key), agent),))


_KINDS: dict[str, Callable[[Fields, str, str], Condition]] = {
    "distance": _comparison,
    "bearing": _comparison,
    "speed": _comparison,
    "feature": _perceived,
    "active": _active,
    "said": _said,
    "ended": _ended,
    "seconds": _passed,
    "all": _several,
    "any": _several,
    "not": _opposite,
}
