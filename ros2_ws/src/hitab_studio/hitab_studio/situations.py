"""Where everything was when something happened, to go back there later."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable

from hitab_studio.scene import Scene

RECENT = 600
"""Moments that are remembered, newest last; at 10 Hz the last minute."""


class Situations:
    """Remembers recent moments by the world's cycle, and for good those of examples."""

    def __init__(self) -> None:
        self._recent: OrderedDict[int, Scene] = OrderedDict()
        self._kept: dict[tuple[str, str, int, int], Scene] = {}

    def see(self, scene: Scene) -> None:
        """Remember a moment; one of the same cycle is replaced: something was placed since."""
        self._recent[scene.cycle] = scene
        self._recent.move_to_end(scene.cycle)
        while len(self._recent) > RECENT:
            self._recent.popitem(last=False)

    def keep(self, agent: str, automaton: str, examples: Iterable[tuple[int, int]]) -> None:
        """Keep the moments of examples, given by number and cycle, that are still remembered."""
        for number, cycle in examples:
            key = (agent, automaton, number, cycle)
            if key in self._kept:
                continue
            scene = self._nearest(cycle)
            if scene is not None:
                self._kept[key] = scene

    def _nearest(self, cycle: int) -> Scene | None:
        # Viewers see one state of several cycles: the next older one is as good.
        for back in range(4):
            if (scene := self._recent.get(cycle - back)) is not None:
                return scene
        return None

    def of(self, agent: str, automaton: str, number: int, cycle: int) -> Scene | None:
        """Return the moment in which an example was recorded, if it is known."""
        return self._kept.get((agent, automaton, number, cycle))
