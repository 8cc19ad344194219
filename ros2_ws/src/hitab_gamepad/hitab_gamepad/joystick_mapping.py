"""Mappings: YAML files that assign meanings to the buttons and axes of a joystick."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator

from hitab_client import DescriptionError
from hitab_client.demonstrating import KEY_ACTIONS
from hitab_core import BoundedNumber, Term, VocabularyError, has
from hitab_core.library import kind_of
from hitab_core.library.yaml_models import NONE_IS_EMPTY, Format, Record, among, open_record
from hitab_core.library.yaml_places import Complaints, Place, read_text, read_yaml
from hitab_ros.timing import PROMPT_S

FORMAT = 1
"""The newest format version that is read."""

SHIPPED = Path(__file__).parent / "joysticks"
WAYS = ("ahead", "left", "turn")
"""Names of the numbers of a velocity."""

DEFLECTION_MIN = 0.5
"""Deflection of a stick, as a fraction of 1, from which on its direction counts."""


class Button(Record):
    """A button, or a half of an axis that counts as one.

    Attributes:
        index: index into the message's buttons or axes.
        above: value of the axis above which it counts as pressed; None for a real button.
        below: value of the axis below which it counts as pressed; None for a real button.
    """

    index: int = Field(alias="axis", ge=0)
    above: float | None = Field(default=None, ge=-1.0, le=1.0)
    below: float | None = Field(default=None, ge=-1.0, le=1.0)

    @property
    def is_axis(self) -> bool:
        """Whether the button is a half of an axis."""
        return self.above is not None or self.below is not None


def _button(value: Any) -> Any:
    if not isinstance(value, dict):
        return {"axis": value}
    if ("above" in value) is ("below" in value):
        raise ValueError("needs either `above:` or `below:`, such as {axis: 7, above: 0.5}")
    return value


def _moving(speed: float) -> float:
    if speed == 0.0 or not math.isfinite(speed):
        raise ValueError(f"must be a number other than 0, not {speed:g}")
    return speed


class Axis(Record):
    """An axis that drives: its index, and the speed at its end, m/s or rad/s, which may be < 0."""

    index: int = Field(alias="axis", ge=0)
    speed: Annotated[float, AfterValidator(_moving)]


def _gauge(value: Any) -> Any:
    if isinstance(value, dict) and ("axis" in value) is ("ahead" in value and "left" in value):
        raise ValueError(
            "needs either `axis:`, or `ahead:` and `left:`, the two axes of a stick, such as "
            "{ahead: 1, left: 0}"
        )
    return value


class Gauge(Record):
    """A source of a behavior's number: where a stick points, or how far an axis is pushed.

    Attributes:
        ahead, left: the axes of a stick, for a number on a circle.
        axis: the axis for any other number.
        low, high: positions of this axis that stand for the number's bounds.
    """

    ahead: int | None = Field(default=None, ge=0)
    left: int | None = Field(default=None, ge=0)
    axis: int | None = Field(default=None, ge=0)
    low: float = Field(default=-1.0, ge=-1.0, le=1.0)
    high: float = Field(default=1.0, ge=-1.0, le=1.0)

    @property
    def axes(self) -> list[int]:
        """The axes of the mapping."""
        return [i for i in (self.ahead, self.left, self.axis) if i is not None]

    def read(self, number: BoundedNumber, axes: Sequence[float]) -> float | None:
        """Return a number's value; None if the stick points nowhere, or has no axis for it."""
        if self.axis is not None:
            share = (axes[self.axis] - self.low) / ((self.high - self.low) or 1.0)
            return number.low + min(max(share, 0.0), 1.0) * (number.high - number.low)
        ahead, left = (axes[i] for i in self.axes)
        if not number.circular or math.hypot(ahead, left) < DEFLECTION_MIN:
            return None
        period = number.high - number.low
        turn = math.atan2(left, ahead) / math.tau * period
        return number.low + (turn - number.low) % period


def _behavior(value: Any) -> str | int:
    if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
        return value
    with suppress(VocabularyError):
        return str(Term.parse(value if isinstance(value, str) else ""))
    raise ValueError(
        f"must be a behavior, such as Forward or GoTo(ball), or the number of one, from 1, "
        f"not {kind_of(value)}"
    )


class Mapping(Record):
    """The meaning of a joystick's buttons and axes.

    Attributes:
        name: the file's name, for messages.
        buttons: the buttons by name.
        hold: name of the dead-man's switch.
        behaviors: by button: a behavior with its targets, or its number in the agent's order.
        actions: by button: one of the demonstrator's actions.
        driving: the axes for driving ahead, driving to the left and turning; any may be missing.
        numbers: sources of the numbers of behaviors, by name.
        deadzone: distance from the center, as a fraction of 1, at which an axis counts as
        released. timeout: how long the joystick may be silent, s.
    """

    format: Format = 1
    name: str = Field(default="", alias=":name")
    buttons: Annotated[dict[str, Annotated[Button, BeforeValidator(_button)]], NONE_IS_EMPTY]
    hold: str
    behaviors: Annotated[
        dict[str, Annotated[str | int, PlainValidator(_behavior)]], NONE_IS_EMPTY
    ] = Field(default_factory=dict)
    actions: Annotated[dict[str, Annotated[str, among(KEY_ACTIONS)]], NONE_IS_EMPTY] = Field(
        default_factory=dict
    )
    driving: Annotated[dict[Annotated[str, among(WAYS)], Axis], NONE_IS_EMPTY] = Field(
        default_factory=dict
    )
    numbers: Annotated[dict[str, Annotated[Gauge, BeforeValidator(_gauge)]], NONE_IS_EMPTY] = (
        Field(default_factory=dict)
    )
    deadzone: float = Field(default=0.1, ge=0.0, le=0.9)
    timeout: float = Field(default=0.5, ge=0.05, le=PROMPT_S)

    @property
    def buttons_min(self) -> int:
        """The least number of buttons that a message must have."""
        used = [b.index for b in self.buttons.values() if not b.is_axis]
        return max(used, default=-1) + 1

    @property
    def axes_min(self) -> int:
        """The least number of axes that a message must have."""
        used = [b.index for b in self.buttons.values() if b.is_axis]
        used += [axis.index for axis in self.driving.values()]
        used += [axis for gauge in self.numbers.values() for axis in gauge.axes]
        return max(used, default=-1) + 1


def shipped_mappings() -> list[str]:
    """Return the names of the shipped mappings."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def read_mapping(given: str) -> Mapping:
    """Read a mapping.

    Args:
        given: path of a file, or the name of a shipped mapping.

    Raises:
        DescriptionError: naming all errors, by file and line.
    """
    path, shipped = Path(given), SHIPPED / f"{given}.yaml"
    if not path.is_file():
        if given not in shipped_mappings():
            raise DescriptionError(
                f'no mapping "{given}": no such file, and none is shipped '
                f"{has(shipped_mappings(), given)}"
            )
        path = shipped
    return parse_mapping(read_text(path, error=DescriptionError), path)


def parse_mapping(text: str, path: Path) -> Mapping:
    r"""Read a mapping from its text.

    Raises:
        DescriptionError: naming each line that is wrong.

    Examples:
        >>> text = "buttons: {A: 0, B: 1, Z: 2}\nhold: B\nbehaviors: {A: Forward}\n"
        >>> parse_mapping(text + "actions: {Z: stop}\n", Path("my.yaml")).behaviors
        {'A': 'Forward'}
    """
    document = read_yaml(text, str(path), error=DescriptionError)
    mapping = open_record(Mapping, document, FORMAT).but(name=path.stem)
    complaints = Complaints(document)
    buttons = mapping.buttons
    for name, button in buttons.items():
        first = next(other for other, same in buttons.items() if same == button)
        if first != name:
            complaints.add(("buttons", name), f"`{name}:` is the same button as {first}")
    terms: list[tuple[Place, str, str]] = [(("hold",), mapping.hold, "hold")]
    terms += [(("behaviors", name), name, "a behavior") for name in mapping.behaviors]
    terms += [(("actions", name), name, action) for name, action in mapping.actions.items()]
    used: dict[str, str] = {}
    for place, name, what in terms:
        if name not in buttons:
            complaints.add(place, f"`{name}` is not among the buttons {has(buttons, name)}")
        elif name in used:
            complaints.add(place, f"`{name}` is used twice: for {used[name]} and for {what}")
        used.setdefault(name, what)
    if "stop" not in mapping.actions.values():
        complaints.add(("actions",), "no button stops the robots: give one the action `stop`")
    complaints.raise_any()
    return mapping
