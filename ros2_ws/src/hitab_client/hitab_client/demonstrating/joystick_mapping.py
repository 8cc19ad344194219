"""Mappings: YAML files that say what the buttons and axes of a joystick do."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from hitab_client.demonstrating.pressed import ACTIONS
from hitab_client.errors import DescriptionError
from hitab_core import Use, VocabularyError, has
from hitab_core.library import Fields
from hitab_core.library.yaml_places import Complaints, read_text, read_yaml

FORMAT = 1
"""The newest format version that is read."""

SHIPPED = Path(__file__).parent / "joysticks"
WAYS = ("ahead", "left", "turn")
"""Of the numbers of a velocity."""

TIMEOUT_MAX_S = 2.0
"""Nobody notices a lost joystick later than this."""


@dataclass(frozen=True)
class Button:
    """A button, or a half of an axis that counts as one.

    Attributes:
        index: in the buttons of the message, or in its axes.
        above: it is pressed while the axis is above this; None: it is no half of an axis.
        below: the same, below.
    """

    index: int
    above: float | None = None
    below: float | None = None

    @property
    def is_axis(self) -> bool:
        """Whether it is a half of an axis."""
        return self.above is not None or self.below is not None


@dataclass(frozen=True)
class Axis:
    """An axis that drives: its index, and m/s or rad/s at its end; negative: the other way."""

    index: int
    speed: float


@dataclass(frozen=True)
class Mapping:
    """What the buttons and axes of a joystick do.

    Attributes:
        name: of the file, for people.
        buttons: by name.
        hold: name of the dead-man's switch.
        behaviors: by button: a behavior with its targets, or its number in the agent's order.
        actions: by button: one of the demonstrator's actions.
        driving: which axis drives ahead, to the left and turns; a missing one does not.
        deadzone: how far from its center an axis counts as released, of 1.
        timeout: how long the joystick may be silent, s.
    """

    name: str
    buttons: dict[str, Button]
    hold: str
    behaviors: dict[str, str | int]
    actions: dict[str, str]
    driving: dict[str, Axis]
    deadzone: float = 0.1
    timeout: float = 0.5

    @property
    def buttons_min(self) -> int:
        """The least number of buttons that a message must have."""
        used = [b.index for b in self.buttons.values() if not b.is_axis]
        return max(used, default=-1) + 1

    @property
    def axes_min(self) -> int:
        """The least number of axes that a message must have."""
        halves = [b.index for b in self.buttons.values() if b.is_axis]
        return max([*halves, *(axis.index for axis in self.driving.values())], default=-1) + 1


def shipped_mappings() -> list[str]:
    """Return the names of the shipped mappings."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def read_mapping(given: str) -> Mapping:
    """Read a mapping.

    Args:
        given: path of a file, or the name of a shipped mapping.

    Raises:
        DescriptionError: naming everything that is wrong, by file and line.
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
    top = Fields(Complaints(document, DescriptionError))
    top.check_format(FORMAT)
    buttons = _buttons(top)
    used: dict[str, str] = {}
    mapping = Mapping(
        path.stem,
        buttons,
        _hold(top, buttons, used),
        _behaviors(top.inner("behaviors"), buttons, used),
        _actions(top, buttons, used),
        _driving(top.inner("driving")),
        _number(top, "deadzone", 0.1, 0.0, 0.9),
        _number(top, "timeout", 0.5, 0.05, TIMEOUT_MAX_S),
    )
    top.done()
    top.complaints.raise_any()
    return mapping


def _buttons(top: Fields) -> dict[str, Button]:
    found: dict[str, Button] = {}
    if "buttons" not in top:
        top.complain("`buttons:` is missing here: names and numbers, such as {A: 0, B: 1}")
    fields = top.inner("buttons")
    for name in fields.names():
        if isinstance(fields.raw(name), dict):
            found[name] = _half(fields.inner(name))
        else:
            found[name] = Button(fields.integer(name, 0, least=0))
    for name, button in found.items():
        first = next(other for other, same in found.items() if same == button)
        if first != name:
            fields.complain(f"`{name}:` is the same button as {first}", name)
    return found


def _half(fields: Fields) -> Button:
    """Read a half of an axis that counts as a button, such as ``{axis: 7, above: 0.5}``."""
    index = fields.integer("axis", least=0)
    above, below = (_limit(fields, key) for key in ("above", "below"))
    if (above is None) is (below is None):
        fields.complain("needs either `above:` or `below:`, such as {axis: 7, above: 0.5}")
    fields.done()
    return Button(index or 0, above, below)


def _limit(fields: Fields, key: str) -> float | None:
    return _number(fields, key, 0.0, -1.0, 1.0) if key in fields else None


def _number(fields: Fields, key: str, default: float, least: float, most: float) -> float:
    value = fields.number(key, default)
    if not isinstance(value, float):
        return default
    if not least <= value <= most:
        fields.complain(f"`{key}: {value:g}` must be from {least:g} to {most:g}", key)
    return value


def _use(
    fields: Fields,
    key: str,
    name: str,
    what: str,
    buttons: dict[str, Button],
    used: dict[str, str],
) -> None:
    """Check that the button that is named at a key is there and does nothing else."""
    if name not in buttons:
        fields.complain(f"`{name}` is not among the buttons {has(buttons, name)}", key)
    elif name in used:
        fields.complain(f"`{name}` is used twice: for {used[name]} and for {what}", key)
    used.setdefault(name, what)


def _hold(top: Fields, buttons: dict[str, Button], used: dict[str, str]) -> str:
    hold = top.text("hold")
    if isinstance(hold, str):
        _use(top, "hold", hold, "hold", buttons, used)
    return hold or ""


def _behaviors(
    fields: Fields, buttons: dict[str, Button], used: dict[str, str]
) -> dict[str, str | int]:
    found: dict[str, str | int] = {}
    for name in fields.names():
        value = fields.raw(name)
        _use(fields, name, name, "a behavior", buttons, used)
        if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
            found[name] = value
            continue
        try:
            found[name] = str(Use.parse(value if isinstance(value, str) else ""))
        except VocabularyError:
            fields.complain(
                f"`{name}: {value}` must be a behavior, such as Forward or GoTo(ball), or the "
                "number of one, from 1",
                name,
            )
    return found


def _actions(top: Fields, buttons: dict[str, Button], used: dict[str, str]) -> dict[str, str]:
    fields = top.inner("actions")
    found = {}
    for name in fields.names():
        action = fields.text(name, "", among=ACTIONS)
        _use(fields, name, name, action, buttons, used)
        found[name] = action
    if "stop" not in found.values():
        top.complain("no button stops the robots: give one the action `stop`", "actions")
    return found


def _driving(fields: Fields) -> dict[str, Axis]:
    found = {}
    for way in WAYS:
        if way not in fields:
            fields.raw(way, None)  # that it is known, if another one is misspelt
            continue
        inner = fields.inner(way)
        index, speed = inner.integer("axis", least=0), inner.number("speed")
        if isinstance(speed, float) and (speed == 0.0 or not math.isfinite(speed)):
            inner.complain(f"`speed: {speed:g}` must be a number other than 0", "speed")
        inner.done()
        found[way] = Axis(index or 0, speed or 0.0)
    fields.done()
    return found
