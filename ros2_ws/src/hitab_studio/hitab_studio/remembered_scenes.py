"""Past positions of everything, to return to them later."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from hitab_studio.scene import Scene

RECENT = 600
"""Number of remembered moments; at 10 Hz, the last minute."""

PAUSED = "paused"

Key = tuple[str, str, int, int]


@dataclass(frozen=True)
class ExampleScenes:
    """The moments of examples, by agent, automaton, number and cycle of the example.

    Attributes:
        scenes: where everything was.
        still: those that were recorded while the world stood still.
    """

    scenes: Mapping[Key, Scene] = field(default_factory=lambda: MappingProxyType({}))
    still: frozenset[Key] = frozenset()

    def of(self, agent: str, automaton: str, number: int, cycle: int) -> Scene | None:
        """Return the moment in which an example was recorded, if it is known."""
        return self.scenes.get((agent, automaton, number, cycle))

    def stood_still(self, agent: str, automaton: str, number: int, cycle: int) -> bool:
        """Whether the world stood still when an example was recorded, as far as is known."""
        return (agent, automaton, number, cycle) in self.still


class RememberedScenes:
    """Remembers recent moments by the world's cycle, and those of examples permanently.

    Attributes:
        kept: the moments of examples; replaced when there are more, never changed.
    """

    def __init__(self) -> None:
        self.kept = ExampleScenes()
        self._recent: OrderedDict[int, Scene] = OrderedDict()
        self._now: Scene | None = None

    def see(self, scene: Scene) -> None:
        """Remember a moment; it replaces one of the same cycle: something was placed since."""
        self._now = scene
        self._recent[scene.cycle] = scene
        self._recent.move_to_end(scene.cycle)
        while len(self._recent) > RECENT:
            self._recent.popitem(last=False)

    def keep(self, agent: str, automaton: str, examples: Iterable[tuple[int, int]]) -> None:
        """Keep the moments of examples, given by number and cycle, that are still remembered."""
        new, still, now = {}, set(), self._now
        for number, cycle in examples:
            key = (agent, automaton, number, cycle)
            if now is not None and now.mode == PAUSED and now.cycle == cycle:
                still.add(key)
            if key not in self.kept.scenes and (scene := self._nearest(cycle)) is not None:
                new[key] = scene
        if new or still - self.kept.still:
            scenes = MappingProxyType({**self.kept.scenes, **new})
            self.kept = ExampleScenes(scenes, self.kept.still | still)

    def _nearest(self, cycle: int) -> Scene | None:
        # Viewers see one state of several cycles: the next older one is as good.
        for back in range(4):
            if (scene := self._recent.get(cycle - back)) is not None:
                return scene
        return None

    def of(self, agent: str, automaton: str, number: int, cycle: int) -> Scene | None:
        """Return the moment in which an example was recorded, if it is known."""
        return self.kept.of(agent, automaton, number, cycle)
