"""The parameters of half-field attack."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

from half_field_world import field
from hitab_world.parameters import ParameterError, at_least
from keepaway_world.parameters import KeepawayParameters


@dataclass(frozen=True)
class HalfFieldParameters(KeepawayParameters):
    """Parameters of the attack: keepaway's with other values, and two more.

    Attributes:
        offside: whether offside ends an episode.
        time_limit: cycles after which an episode ends.
    """

    WORLD = "half-field"
    LIMITS = MappingProxyType({**KeepawayParameters.LIMITS, "takers": at_least(1)})

    takers: int = 3
    width: float = field.LENGTH
    height: float = field.WIDTH
    taker_speed: float = 1.0
    ball_collides: bool = True
    stuck_area: float = 0.0
    offside: bool = False
    time_limit: int = 500

    def __post_init__(self) -> None:
        """Refuse a field of another size than the server's.

        Raises:
            ParameterError: if a value is invalid.
        """
        super().__post_init__()
        if (self.width, self.height) != (field.LENGTH, field.WIDTH):
            raise ParameterError(
                f"width and height are {self.width:g} and {self.height:g}; half a field has "
                f"{field.LENGTH:g} and {field.WIDTH:g} m"
            )
