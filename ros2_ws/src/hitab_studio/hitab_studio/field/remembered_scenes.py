"""Remembered scenes of the world, so that a person can go back to them."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping
from types import MappingProxyType

from hitab_studio.field.scene import Scene

RECENT = 600
"""Maximum number of remembered scenes; those of the last minute, or of a longer time."""

THINGS_MAX = 600_000
"""Maximum number of things in the remembered scenes together; a thing takes 40 bytes."""

Key = tuple[str, str, int, int]
"""Key of an example: agent, automaton, number and cycle."""


class RememberedScenes:
    """Remembers recent scenes by the world's cycle, and the scenes of examples permanently.

    Attributes:
        kept: the scenes of examples; immutable, replaced as a whole.
    """

    def __init__(self) -> None:
        self.kept: Mapping[Key, Scene] = MappingProxyType({})
        self._recent: OrderedDict[int, Scene] = OrderedDict()

    def see(self, scene: Scene) -> None:
        """Remember a scene, in place of an earlier one of the same cycle, before a placement."""
        self._recent[scene.cycle] = scene
        self._recent.move_to_end(scene.cycle)
        while len(self._recent) > min(RECENT, THINGS_MAX // max(1, len(scene.names))):
            self._recent.popitem(last=False)

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
