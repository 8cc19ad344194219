"""Conditions of a lesson, in a person's terms.

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
from typing import Annotated, Any, ClassVar, Self

from pydantic import AfterValidator, Field, model_validator

from hitab_client.showing.world_view import WorldView
from hitab_core.library.yaml_models import OneOf, Record, Texts


class Condition(Record):
    """A condition that can be evaluated and described."""

    def holds(self, view: WorldView) -> bool:
        """Whether the condition holds in this view."""
        raise NotImplementedError

    def describe(self, view: WorldView | None = None) -> str:
        """Return the condition in words, with the current value if a view is given."""
        raise NotImplementedError

    def about(self, agent: str) -> Condition:
        """Return the condition with this agent where it names none."""
        if getattr(self, "agent", None) == "":
            return self.but(agent=agent)
        return self

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> Any:
        if cls is not Condition:
            return handler(source)
        return OneOf(_KINDS).__get_pydantic_core_schema__(source, handler)


class Limited(Condition):
    """A value above or below a limit; a missing value is neither."""

    below: float | None = None
    above: float | None = None

    @model_validator(mode="after")
    def _has_limit(self) -> Self:
        if self.below is None and self.above is None:
            raise ValueError("needs `below:` or `above:`")
        return self

    @property
    def named(self) -> str:
        """Text of the compared value, such as ``speed of ball``."""
        raise NotImplementedError

    def value(self, view: WorldView) -> float:
        """Return the value to compare."""
        raise NotImplementedError

    def holds(self, view: WorldView) -> bool:
        """Whether the value lies within the limits."""
        value = self.value(view)
        return (
            value == value
            and (self.below is None or value < self.below)
            and (self.above is None or value > self.above)
        )

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``distance of keeper_1 and ball below 4 (is 5.2)``."""
        limits = [f"below {self.below:g}"] if self.below is not None else []
        limits += [f"above {self.above:g}"] if self.above is not None else []
        current = ""
        if view is not None:
            value = self.value(view)
            current = f" (is {value:.2f})" if value == value else " (has no value)"
        return f"{self.named} {' and '.join(limits)}{current}"


def _two(things: tuple[str, ...]) -> tuple[str, ...]:
    if len(things) != 2:
        raise ValueError("needs 2 things, such as [keeper_1, ball]")
    return things


class Distance(Limited):
    """The distance of two things, m."""

    what: ClassVar[str] = "distance"
    things: Annotated[Texts, AfterValidator(_two)] = Field(alias="distance")

    @property
    def named(self) -> str:
        """Text of the compared value."""
        return f"{self.what} of {' and '.join(self.things)}"

    def value(self, view: WorldView) -> float:
        """Return the value to compare."""
        figure: float = getattr(view, self.what)(*self.things)
        return figure


class Bearing(Distance):
    """The angle between the heading of a thing and the direction to another, degrees."""

    what: ClassVar[str] = "bearing"
    things: Annotated[Texts, AfterValidator(_two)] = Field(alias="bearing")


class Speed(Distance):
    """The speed of a thing, m/s."""

    what: ClassVar[str] = "speed"
    things: Annotated[Texts, Field(min_length=1, max_length=1)] = Field(alias="speed")


class FeatureValue(Limited):
    """A feature of an agent."""

    feature: str
    agent: str = ""

    @property
    def named(self) -> str:
        """Text of the compared value."""
        return f"{self.feature} of {self.agent}"

    def value(self, view: WorldView) -> float:
        """Return the perceived value, or NaN."""
        return view.reading(self.agent, self.feature)


class ActiveState(Condition):
    """A state among an agent's active states, with or without its targets."""

    state: str = Field(alias="active")
    agent: str = ""

    def holds(self, view: WorldView) -> bool:
        """Whether the agent performs the state, at any level."""
        path = (view.paths or {}).get(self.agent, ())
        return any(label == self.state or label.split("(")[0] == self.state for label in path)

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``keeper_1 in GotoBall``."""
        current = ""
        if view is not None:
            path = (view.paths or {}).get(self.agent, ())
            current = f" (is in {' > '.join(path) if path else 'nothing'})"
        return f"{self.agent} in {self.state}{current}"


class Said(Condition):
    """An agent has said something since the step began."""

    by: str = Field(alias="said")

    def holds(self, view: WorldView) -> bool:
        """Whether the agent has said something."""
        return self.by in view.said

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``keeper_2 has said something``."""
        return f"{self.by} has said something"


class Ended(Condition):
    """An episode has ended since the step began, with this outcome or ``any``."""

    how: str = Field(alias="ended")

    def holds(self, view: WorldView) -> bool:
        """Whether such an episode has ended."""
        return bool(view.ended) if self.how == "any" else self.how in view.ended

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``the episode has ended (taken)``."""
        return "the episode has ended" + ("" if self.how == "any" else f" ({self.how})")


class Passed(Condition):
    """Simulated time has passed since the step began."""

    seconds: float

    def holds(self, view: WorldView) -> bool:
        """Whether the time has passed, with half a millisecond of tolerance."""
        return view.seconds >= self.seconds - 5e-4

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``1.5 s have passed``."""
        return f"{self.seconds:g} s have passed"


class All(Condition):
    """All of some conditions."""

    parts: list[Condition] = Field(alias="all", min_length=1)
    joined: ClassVar[str] = " and "
    suffices: ClassVar[Callable[[list[bool]], bool]] = all

    def holds(self, view: WorldView) -> bool:
        """Whether enough conditions hold; all are evaluated, to detect wrong names at once."""
        return type(self).suffices([part.holds(view) for part in self.parts])

    def describe(self, view: WorldView | None = None) -> str:
        """Return the parts, joined."""
        return self.joined.join(part.describe(view) for part in self.parts)

    def about(self, agent: str) -> Condition:
        """Return the conditions with this agent where a part names none."""
        return self.but(parts=[part.about(agent) for part in self.parts])


class AnyOf(All):
    """Any of some conditions."""

    parts: list[Condition] = Field(alias="any", min_length=1)
    joined: ClassVar[str] = " or "
    suffices: ClassVar[Callable[[list[bool]], bool]] = any


class Not(Condition):
    """The opposite of a condition."""

    part: Condition = Field(alias="not")

    def holds(self, view: WorldView) -> bool:
        """Whether the condition does not hold."""
        return not self.part.holds(view)

    def describe(self, view: WorldView | None = None) -> str:
        """Return text such as ``not (keeper_2 has said something)``."""
        return f"not ({self.part.describe(view)})"

    def about(self, agent: str) -> Condition:
        """Return the condition with this agent where it names none."""
        return self.but(part=self.part.about(agent))


_KINDS: dict[str, type[Condition]] = {
    "distance": Distance,
    "bearing": Bearing,
    "speed": Speed,
    "feature": FeatureValue,
    "active": ActiveState,
    "said": Said,
    "ended": Ended,
    "seconds": Passed,
    "all": All,
    "any": AnyOf,
    "not": Not,
}
