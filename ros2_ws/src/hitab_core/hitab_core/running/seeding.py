"""Seeds for random generators, the same on every machine and in every run.

An episode is identified by the seed of its run and its number in the run. Worlds and agents derive
the seeds of their own generators from these two, whether they run in one process or in many, so
that the same seed and the same answers give the same episode. This uses SHA-256 because ``hash``
changes with the version of Python and, for text, with each process.
"""

from __future__ import annotations

import hashlib
import json


def derived_seed(*parts: int | str) -> int:
    """Return a 64-bit seed that depends on all ``parts`` and on their order."""
    text = json.dumps(parts, separators=(",", ":"))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")


def agent_seed(seed: int, episode: int, name: str) -> int:
    """Return the seed of one agent's random generator during one episode.

    Args:
        seed: seed of the run, as every percept carries it.
        episode: number of the episode in the run, as every percept carries it.
        name: name of the agent.
    """
    return derived_seed("agent", seed, episode, name)


def world_seed(seed: int, episode: int) -> int:
    """Return the seed of a world's random generator during one episode."""
    return derived_seed("world", seed, episode)
