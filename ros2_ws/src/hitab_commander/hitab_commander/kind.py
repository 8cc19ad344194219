"""A kind of commander: what it can order and what it perceives of its subordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from hitab_core.commanding import OTHERS


class Over(StrEnum):
    """How a feature sums up what is observed in each subordinate."""

    ANY = "any"
    ALL = "all"
    FRACTION = "fraction"
    COUNT = "count"
    MEAN = "mean"
    MINIMUM = "minimum"
    MAXIMUM = "maximum"
    VALUE = "value"  # of one subordinate, which is the feature's parameter
    GROUP = "group"  # of the positions: x, y, spread


EXTREMES = (Over.MINIMUM, Over.MAXIMUM)
GROUP_PARTS = ("x", "y", "spread")


@dataclass(frozen=True, slots=True)
class Observation:
    """What is looked at in one subordinate: a flag, an active state, or a feature.

    Attributes:
        flag, active, feature: exactly one of them is not empty. ``active`` names a state at any
            level, or the top-level behavior.
        below, above: limits that make a question of a feature's value.
    """

    flag: str = ""
    active: str = ""
    feature: str = ""
    below: float | None = None
    above: float | None = None

    @property
    def is_question(self) -> bool:
        """Whether it is true or false by itself."""
        return not self.feature or self.below is not None or self.above is not None


@dataclass(frozen=True, slots=True)
class GroupFeature:
    """A feature of a commander.

    Attributes:
        over: how the subordinates are summed up.
        of: what is observed in each; for `Over.GROUP`, ``part`` of their positions instead.
        role: whose; empty: everybody's.
        parameter: of a feature of one subordinate, `Over.VALUE`.
    """

    name: str
    over: Over
    of: Observation = Observation()
    role: str = ""
    parameter: str = ""
    part: str = ""


@dataclass(frozen=True, slots=True)
class Pick:
    """A target: the subordinate with the least or the greatest value, or that of a number.

    Of several with the same value, the first in the commander's list is picked. ``number`` counts
    from 1, among those with the role.
    """

    name: str
    over: Over = Over.MINIMUM
    of: Observation = Observation()
    role: str = ""
    number: int = 0


@dataclass(frozen=True, slots=True)
class OrderMap:
    """An order, and what it has the subordinates perform.

    Attributes:
        name: of the order: a basic behavior of the commander.
        behaviors: by receiver: a role, ``parameter`` for the subordinate that it is bound to, or
            `OTHERS`. Empty text: perform nothing; None: go on with what is performed.
        parameter: its parameter, if it is about one subordinate.
    """

    name: str
    behaviors: Mapping[str, str | None] = field(default_factory=dict)
    parameter: str = ""

    def for_role(self, role: str) -> str | None:
        """Return what subordinates with a role perform; None: they go on."""
        return self.behaviors.get(role, self.behaviors.get(OTHERS))

    def covers(self, role: str) -> bool:
        """Whether it says what subordinates with a role do."""
        return role in self.behaviors or OTHERS in self.behaviors


@dataclass(frozen=True)
class CommanderKind:
    """What commanders of one kind have in common; their domain is made from it.

    Attributes:
        name: of the kind, and of its domain.
        deadline: s after which a subordinate that was not heard of is left out.
        rate: Hz at which it decides when nothing changes in between.
        report_period: s between two reports of values that change, in the subordinates' time.
    """

    name: str
    orders: tuple[OrderMap, ...]
    features: tuple[GroupFeature, ...] = ()
    targets: tuple[Pick, ...] = ()
    deadline: float = 3.0
    rate: float = 10.0
    report_period: float = 0.5

    @property
    def _looked_at(self) -> tuple[Observation, ...]:
        return (*(f.of for f in self.features), *(t.of for t in self.targets))

    @property
    def asked(self) -> tuple[str, ...]:
        """The subordinates' features that are looked at, each once."""
        return tuple(dict.fromkeys(of.feature for of in self._looked_at if of.feature))

    @property
    def asks_states(self) -> bool:
        """Whether subordinates have to report what is active inside their top-level behavior."""
        return any(of.active for of in self._looked_at)

    @property
    def asks_position(self) -> bool:
        """Whether subordinates have to report where they are."""
        return any(feature.over is Over.GROUP for feature in self.features)
