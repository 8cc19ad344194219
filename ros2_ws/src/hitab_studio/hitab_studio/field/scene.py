"""The visible part of a world, compact enough to send to a browser ten times a second.

The roster, a message with names, kinds and sizes, is sent when it changes. Positions are sent as a
binary frame, little-endian:

    uint32  1, uint32 n, float64 cycle
    float32 x, y, heading of each thing, n times
    uint8   color of the active state of each, 255 none
    uint8   mode of each, 0 none, else 1 + index in MODES
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from hitab_msgs import msg
from numpy.typing import NDArray

from hitab_ros.messages.stamps import seconds_of
from hitab_studio.kept import while_same

SILENT_MODE = "silent"
"""The mode of an agent that does not answer."""

SHOWN_MODES = ("idle", "performing", "training", "testing", SILENT_MODE)
NO_COLOR = 255
STATE_COLORS = (
    "#3b82d6", "#2fa36b", "#e08a2c", "#a66bd4", "#d6568a", "#2aa5b8",
    "#8f8a2e", "#d65a4a", "#6b7bd6", "#4f9a8f", "#b87a4b", "#8a93a3",
)  # fmt: skip
"""Colors of states, as in static/drawing.js; further states share them."""

AGENT_COLOR = "#5c7ea8"
"""Color of an agent in no state, and of things without a color of their own."""

AS_IN_STATE = ("world", "cycle", "episode", "episode_cycle", "mode", "note")
KNOWN_FIELDS = ("x", "y", "heading", "vx", "vy")


@dataclass(frozen=True, slots=True)
class Appearance:
    """Appearance of a kind of thing; see the message `Appearance`.

    The defaults, for kinds without a declared appearance, are those of agents.
    """

    color: str = AGENT_COLOR
    shape: str = msg.Look.DISC
    faces: bool = True
    labelled: bool = True
    opacity: float = 1.0
    layer: int = 0


@dataclass(frozen=True)
class Scene:
    """A moment of a world.

    Attributes:
        cycle, episode, episode_cycle, mode, note: as in `WorldState`.
        seconds: simulated time, s.
        size: width and height of the field, m.
        names, kinds: name and kind of each of the n things.
        radii: radius of each thing, m, shape (n,).
        places: x, y, heading, vx, vy of each thing, shape (n, 5).
        said: messages spoken by things, by index.
        looks: appearance of each kind of thing.
        center: middle of the field, m.
        real: whether the things are real robots, which cannot be placed.
    """

    size: tuple[float, float]
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    radii: tuple[float, ...]
    places: NDArray[np.float64]
    looks: Mapping[str, Appearance]
    world: str = ""
    cycle: int = 0
    episode: int = 0
    episode_cycle: int = 0
    mode: str = ""
    note: str = ""
    seconds: float = 0.0
    said: Mapping[int, str] = field(default_factory=lambda: MappingProxyType({}))
    center: tuple[float, float] = (0.0, 0.0)
    real: bool = False

    def everything(self) -> dict[str, dict[str, float]]:
        """Return the places of everything, by name, as `WorldClient.place` takes them."""
        rows = self.places.tolist()
        return {
            name: dict(zip(KNOWN_FIELDS, row, strict=True))
            for name, row in zip(self.names, rows, strict=True)
        }


def scene_of(state: Any) -> Scene:
    """Return the scene of a `WorldState` message."""
    entities = state.entities
    # Old recordings have a stamp instead of a header.
    stamp = state.header.stamp if hasattr(state, "header") else state.stamp
    places = np.array(
        [(e.x, e.y, e.heading, e.vx, e.vy) for e in entities], dtype=np.float64
    ).reshape(len(entities), 5)
    places.setflags(write=False)
    return Scene(
        **{name: getattr(state, name) for name in AS_IN_STATE},
        seconds=seconds_of(stamp),
        size=(state.width, state.height),
        names=tuple([e.name for e in entities]),
        kinds=tuple([e.kind for e in entities]),
        radii=tuple([e.radius for e in entities]),
        places=places,
        said=MappingProxyType({i: e.say for i, e in enumerate(entities) if e.say}),
        looks=MappingProxyType(_looks(state, {e.kind for e in entities})),
    )


def _looks(state: Any, kinds: set[str]) -> dict[str, Appearance]:
    """Return the appearance of each kind: as declared by the world, or the default."""
    declared = {
        it.kind: Appearance(
            it.color or AGENT_COLOR,
            it.shape,
            it.faces,
            it.labelled,
            round(it.opacity, 3),
            it.layer,
        )
        for it in state.looks
    }
    return {kind: declared.get(kind, Appearance()) for kind in sorted(kinds)}


class Palette:
    """Assigns colors to states, in the order in which states become active.

    Attributes:
        given: the assigned colors, by state.
    """

    def __init__(self) -> None:
        self.given: dict[str, int] = {}

    @property
    def states(self) -> list[str]:
        """All states with a color."""
        return [*self.given]

    def index(self, state: str) -> int:
        """Return the color of a state."""
        if not state:
            return NO_COLOR
        return self.given.setdefault(state, len(self.given) % len(STATE_COLORS))

    def color(self, state: str) -> str:
        """Return the color of a state in CSS notation; "" if the state has none."""
        return STATE_COLORS[self.index(state)] if state else ""


def roster(scene: Scene, palette: Palette) -> str:
    """Return the message with the names and appearances of the things in the frames."""
    return json.dumps(
        {
            "t": "roster",
            "world": scene.world,
            "size": scene.size,
            "center": scene.center,
            "real": scene.real,
            "names": scene.names,
            "kinds": scene.kinds,
            "looks": {kind: asdict(look) for kind, look in scene.looks.items()},
            "radii": scene.radii,
            "legend": palette.states[: len(STATE_COLORS)],
        }
    )


def frame(scene: Scene, doing: Mapping[str, tuple[str, str]], palette: Palette) -> bytes:
    """Return the binary frame of a scene.

    Args:
        scene: the scene to encode.
        doing: mode and active state of each agent, by name.
        palette: assigns colors to states.
    """
    places = np.ascontiguousarray(scene.places[:, :3], dtype="<f4").tobytes()
    head = struct.pack("<IId", 1, len(scene.names), float(scene.cycle))
    return head + places + _codes(scene.names, doing, palette)


@while_same
def _codes(
    names: tuple[str, ...], doing: Mapping[str, tuple[str, str]], palette: Palette
) -> bytes:
    """Return the colors of the active states of things, then the numbers of their modes."""
    nothing = ("", "")
    shown = [doing.get(name, nothing) for name in names]
    numbers = {mode: number for number, mode in enumerate(SHOWN_MODES, 1)}
    colors = bytes([palette.index(state) for _, state in shown])
    return colors + bytes([numbers.get(mode, 0) for mode, _ in shown])


def said_message(scene: Scene) -> str:
    """Return the message with the messages spoken by things."""
    return json.dumps({"t": "say", "said": [[i, text] for i, text in scene.said.items()]})


def state_shown(status: msg.AgentStatus) -> str:
    """Return the state that determines an agent's color, without targets.

    This is the role given by a commander, or else the outermost active state.
    """
    path = status.active_path
    if status.order.commander and status.mode == status.PERFORMING:
        path = [status.behavior]
    return str(path[0].partition("(")[0]) if path else ""
