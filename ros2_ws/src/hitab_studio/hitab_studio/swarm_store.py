"""Data that all pages share."""

from __future__ import annotations

from dataclasses import dataclass, field

from hitab_studio.scene import Palette
from hitab_studio.swarm_state import SwarmState


@dataclass
class SwarmStore:
    """The state of the swarm, and other data that pages share.

    Attributes:
        known: of the swarm.
        version: raised with each change that pages show.
        palette: the colors of states.
        placements: where things were before they were placed, newest last, for undo.
        snapshots: names of the world's snapshots.
    """

    known: SwarmState = field(default_factory=SwarmState)
    version: int = 0
    palette: Palette = field(default_factory=Palette)
    placements: list[dict[str, dict[str, float]]] = field(default_factory=list)
    snapshots: tuple[str, ...] = ()

    def touch(self) -> None:
        """Say that something has changed."""
        self.version += 1

    def take(self, known: SwarmState) -> None:
        """Know this from now on; of another swarm, or another start of it, forget the rest."""
        before, self.known = self.known, known
        if known.target != before.target:
            self.placements.clear()
            self.snapshots = ()
        if known.scene and before.scene and known.scene.episode != before.scene.episode:
            self.placements.clear()  # that was another game
        if known.revision != before.revision:
            self.touch()
