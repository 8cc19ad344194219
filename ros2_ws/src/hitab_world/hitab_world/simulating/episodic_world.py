"""The base class of simulated worlds: it counts runs, episodes and cycles."""

from __future__ import annotations

from collections.abc import Mapping

from hitab_world.world import WorldError


class EpisodicWorld:
    """A base class for worlds, see `hitab_world.world.World`, that counts episodes and cycles.

    Args:
        seed: the run's seed. Episode i draws from a generator seeded with it and i, so that any
            episode can be replayed by itself.
    """

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.episode = self.cycle = self.episode_cycle = 0
        self.ended = ""
        self.refused: Mapping[str, str] = {}

    def begin_episode(self, episode: int | None, seed: int | None) -> None:
        """Begin to count an episode: the next one of this run, or the given ones."""
        if seed is not None:
            self.seed = int(seed)
        self.episode = self.episode + 1 if episode is None else int(episode)
        self.episode_cycle = 0
        self.ended = ""
        self.refused = {}

    def refuse_after_end(self) -> None:
        """Check that another cycle can be played.

        Raises:
            WorldError: if the episode has ended.
        """
        if self.ended:
            raise WorldError(
                f'episode {self.episode} has ended ("{self.ended}"); reset() begins the next one'
            )
