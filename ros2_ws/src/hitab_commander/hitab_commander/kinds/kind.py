"""A kind of commander: its orders, and the features of its subordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from hitab_core.orders import ALL_OTHERS


class Over(StrEnum):
    """How a feature aggregates what is observed in each subordinate."""

    ANY = "any"
    ALL = "all"
    FRACTION = "fraction"
    COUNT = "count"
    MEAN = "mean"
    MINIMUM = "minimum"
    MAXIMUM = "maximum"
    VALUE = "value"  # the value of one subordinate, which is the feature's parameter
    GROUP = "group"  # an aggregate of the positions: x, y, spread


EXTREMES = (Over.MINIMUM, Over.MAXIMUM)
GROUP_PARTS = ("x", "y", "spread")


@dataclass(frozen=True, slots=True)
class Observation:
    """An observation of one subordinate: a flag, an active state, or a feature.

    Attributes:
        flag, active, feature: the observed flag, active state or feature; exactly one is not
            empty. ``active`` names a state at any level, or the top-level behavior.
        below, above: limits that turn a feature's value into true or false.
    """

    flag: str = ""
    active: str = ""
    feature: str = ""
    below: float | None = None
    above: float | None = None

    @property
    def is_question(self) -> bool:
        """Whether the observed value is true or false."""
        return not self.feature or self.below is not None or self.above is not None


@dataclass(frozen=True, slots=True)
class GroupFeature:
    """A feature of a commander.

    Attributes:
        over: how the subordinates are aggregated.
        of: the observation of each subordinate; unused for `Over.GROUP`.
        role: role of the subordinates that count; empty for all.
        parameter: the parameter of a feature of one subordinate (`Over.VALUE`).
        part: for `Over.GROUP`, the aggregate of the positions.
    """

    name: str
    over: Over
    of: Observation = Observation()
    role: str = ""
    parameter: str = ""
    part: str = ""


@dataclass(frozen=True, slots=True)
class Pick:
    """A target: the subordinate with the smallest or the largest value, or with a number.

    Among equal values, the first subordinate in the commander's list is picked. ``number`` counts
    from 1 among the subordinates with the role.
    """

    name: str
    over: Over = Over.MINIMUM
    of: Observation = Observation()
    role: str = ""
    number: int = 0


@dataclass(frozen=True, slots=True)
class OrderMap:
    """An order, and the behaviors that subordinates perform for it.

    Attributes:
        name: the order's name, which is a basic behavior of the commander.
        behaviors: behaviors by receiver: a role, ``parameter`` for the subordinate that is bound
            to it, or `ALL_OTHERS`. An empty text means to perform nothing, None to continue.
        parameter: the order's parameter, if the order is about one subordinate; else empty.
    """

    name: str
    behaviors: Mapping[str, str | None] = field(default_factory=dict)
    parameter: str = ""

    def for_role(self, role: str) -> str | None:
        """Return the behavior for subordinates with a role; None if they continue."""
        return self.behaviors.get(role, self.behaviors.get(ALL_OTHERS))

    def covers(self, role: str) -> bool:
        """Return whether the order has a behavior for subordinates with a role."""
        return role in self.behaviors or ALL_OTHERS in self.behaviors


@dataclass(frozen=True)
class CommanderKind:
    """The orders and features that commanders of one kind share; their domain is made from it.

    Attributes:
        name: name of the kind and of its domain.
        deadline: time without a report after which a subordinate counts as silent, s.
        rate: rate of decisions while nothing changes, Hz.
        report_period: time between two reports of changing values, s of the subordinates' time.
        described: the kind's description, as in a file.
    """

    name: str
    orders: tuple[OrderMap, ...]
    features: tuple[GroupFeature, ...] = ()
    targets: tuple[Pick, ...] = ()
    deadline: float = 3.0
    rate: float = 10.0
    report_period: float = 0.5
    described: Mapping[str, Any] = field(default_factory=dict, compare=False, repr=False)

    @property
    def _observations(self) -> tuple[Observation, ...]:
        return (*(f.of for f in self.features), *(t.of for t in self.targets))

    @property
    def asked(self) -> tuple[str, ...]:
        """The subordinates' features that are observed, each once."""
        return tuple(dict.fromkeys(of.feature for of in self._observations if of.feature))

    @property
    def asks_states(self) -> bool:
        """Whether subordinates must report the active states inside their top-level behavior."""
        return any(of.active for of in self._observations)

    @property
    def asks_position(self) -> bool:
        """Whether subordinates must report their positions."""
        return any(feature.over is Over.GROUP for feature in self.features)
