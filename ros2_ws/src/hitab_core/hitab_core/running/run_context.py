"""The context shared by all performances of one agent, and the interface of a performance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from hitab_core.repertoire import Repertoire
from hitab_core.running.feature_cache import FeatureCache
from hitab_core.running.given_numbers import NumberRange
from hitab_core.running.observing import Observe, guest


class Running(Protocol):
    """A behavior being performed."""

    @property
    def raised(self) -> set[str]:
        """The raised flags that are still up."""

    @property
    def active_path(self) -> list[str]:
        """Labels of the active states, outermost first; none in a basic behavior."""

    def start(self) -> None:
        """Start performing from the beginning."""

    def tick(self) -> None:
        """Perform one timestep."""

    def stop(self) -> None:
        """Stop performing, innermost first."""

    def memento(self) -> tuple[Any, ...]:
        """Return its states, to restore them later; of an automaton, the active label first."""

    def restore(self, memento: Any) -> None:
        """Be in the states of a memento; behaviors that are not active are stopped or started."""


@dataclass(slots=True)
class Clock:
    """The simulated time of an agent's last percept, s; set together with the percept.

    Attributes:
        now: the time, s.
        changes: how often a state, a flag or a timer was set, on any level.
    """

    now: float = 0.0
    changes: int = 0


@dataclass(frozen=True, slots=True)
class RunContext:
    """The context shared by everything that one agent performs.

    Attributes:
        repertoire: the available behaviors.
        body: body of this agent, made by the domain.
        feature_cache: the agent's features, read from this body.
        draw: uniform random numbers on [0, 1) from the agent's own seeded generator.
        most_probable: take the most probable next state instead of drawing one.
        observe: called at each change of state, after the decision and before the new state
            starts. Its exceptions do not propagate; see `hitab_core.running.observing`.
        clock: clock of the timers.
        number_range: range around the moments shown in which there are numbers.
    """

    repertoire: Repertoire
    body: Any
    feature_cache: FeatureCache
    draw: Callable[[], float]
    most_probable: bool = False
    observe: Observe | None = None
    clock: Clock = field(default_factory=Clock)
    number_range: NumberRange = field(default_factory=NumberRange)

    def __post_init__(self) -> None:
        """Wrap the observer so that its exceptions do not propagate."""
        if self.observe is not None:
            object.__setattr__(self, "observe", guest(self.observe))
