"""Remembered scenes of the world, so that a person can go back to them."""

from __future__ import annotations

from bisect import bisect_right
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from types import MappingProxyType

from hitab_studio.field.scene import Scene

RECENT = 3000
"""Maximum number of remembered scenes: a minute of 50 cycles a second, or a longer time."""

THINGS_MAX = 600_000
"""Maximum number of things in the remembered scenes together; a thing takes 40 bytes."""

Key = tuple[str, str, int, int]
"""Key of an example: agent, automaton, number and cycle."""


class RememberedScenes:
    """Remembers recent scenes by their moment, and the scenes of examples permanently.

    A moment is the world's cycle, or with real robots a time.

    Attributes:
        kept: the scenes of examples; immutable, replaced as a whole.
    """

    def __init__(self) -> None:
        self.kept: Mapping[Key, Scene] = MappingProxyType({})
        self._recent: OrderedDict[float, Scene] = OrderedDict()

    @property
    def moments(self) -> list[float]:
        """The moments of the recent scenes, in order."""
        return [*self._recent]

    def see(self, scene: Scene, at: float | None = None) -> None:
        """Remember a scene, in place of an earlier one of the same cycle, before a placement.

        Later ones are forgotten: the world went back.
        """
        moment = scene.cycle if at is None else at
        while self._recent and next(reversed(self._recent)) >= moment:
            self._recent.popitem()
        self._recent[moment] = scene
        while len(self._recent) > min(RECENT, THINGS_MAX // max(1, len(scene.names))):
            self._recent.popitem(last=False)

    def at(self, moment: float, step: int = 0) -> tuple[float, Scene] | None:
        """Return the scene at a moment, or some scenes before or after; None if there is none.

        Args:
            moment: the moment; the last scene until then is meant.
            step: number of scenes after that one.
        """
        moments = self.moments
        if not moments:
            return None
        number = max(0, bisect_right(moments, moment) - 1 + step)
        found = moments[min(number, len(moments) - 1)]
        return found, self._recent[found]

    def keep(self, agent: str, automaton: str, examples: Iterable[tuple[int, int]]) -> None:
        """Keep the scenes of examples, given by number and cycle, if still remembered."""
        new = {}
        for number, cycle in examples:
            key = (agent, automaton, number, cycle)
            # Viewers receive only some cycles, so the next older one is close enough.
            near = (self._recent.get(cycle - back) for back in range(4))
            scene = next((one for one in near if one is not None), None)
            if key not in self.kept and scene is not None:
                new[key] = scene
        if new:
            self.kept = MappingProxyType({**self.kept, **new})
