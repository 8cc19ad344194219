"""Past positions of everything, to return to them later."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping
from types import MappingProxyType

from hitab_studio.scene import Scene

RECENT = 600
"""Number of remembered moments; at 10 Hz, the last minute."""

Key = tuple[str, str, int, int]
"""An example: its agent, automaton, number and cycle."""


class RememberedScenes:
    """Remembers recent moments by the world's cycle, and those of examples permanently.

    Attributes:
        kept: the moments of examples; replaced when there are more, never changed.
    """

    def __init__(self) -> None:
        self.kept: Mapping[Key, Scene] = MappingProxyType({})
        self._recent: OrderedDict[int, Scene] = OrderedDict()

    def see(self, scene: Scene) -> None:
        """Remember a moment; it replaces one of the same cycle: something was placed since."""
        self._recent[scene.cycle] = scene
        self._recent.move_to_end(scene.cycle)
        while len(self._recent) > RECENT:
            self._recent.popitem(last=False)

    def keep(self, agent: str, automaton: str, examples: Iterable[tuple[int, int]]) -> None:
        """Keep the moments of examples, given by number and cycle, that are still remembered."""
        new = {}
        for number, cycle in examples:
            key = (agent, automaton, number, cycle)
            # Viewers see one state of several cycles: the next older one is as good.
            near = (self._recent.get(cycle - back) for back in range(4))
            scene = next((one for one in near if one is not None), None)
            if key not in self.kept and scene is not None:
                new[key] = scene
        if new:
            self.kept = MappingProxyType({**self.kept, **new})
