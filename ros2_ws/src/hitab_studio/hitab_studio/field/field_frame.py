"""The present field, prepared once for all pages."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from hitab_studio.field.scene import Palette, Scene, frame, roster

EMPTY = json.dumps(
    {"t": "roster", "world": "", "size": [20.0, 20.0], "names": [], "kinds": [], "looks": {}}
    | {"radii": [], "legend": [], "center": [0.0, 0.0], "real": False}
)
"""Roster of an empty field."""


class FieldFrame:
    """The latest scene of the swarm, encoded for pages.

    Attributes:
        frame: the scene as a binary frame.
        frames: number of frames so far.
        roster: message with the names and appearances of the things in the frame; "" before the
            first scene.
    """

    def __init__(self, palette: Palette) -> None:
        self.frame = b""
        self.frames = 0
        self.roster = ""
        self._palette = palette
        self._roster_key: tuple[Any, ...] = ()

    def draw(self, scene: Scene, doing: Mapping[str, tuple[str, str]]) -> bool:
        """Encode a scene; return whether the roster has changed.

        Args:
            scene: the scene to encode.
            doing: mode and active state of each agent, by name.
        """
        palette = self._palette
        self.frame = frame(scene, doing, palette)
        self.frames += 1
        key = (scene.names, scene.size, scene.center, scene.real, len(palette.states))
        if key == self._roster_key:
            return False
        self._roster_key = key
        self.roster = roster(scene, palette)
        return True

    def clear(self) -> str:
        """Discard the scene; return the roster of an empty field."""
        self.frame = b""
        self.roster = ""
        self._roster_key = ()
        return EMPTY
