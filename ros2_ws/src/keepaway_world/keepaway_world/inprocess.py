"""Play keepaway in one process; see `hitab_world.inprocess`, which works for any world.

Example::

    world = KeepawayWorld(seed=7)
    repertoire = Repertoire(DOMAIN, library)
    results = play(world, perform(world, repertoire, "Keepaway"), episodes=200)
"""

from __future__ import annotations

from hitab_world.inprocess import (
    AutomatonPlayer,
    Player,
    Policy,
    PolicyPlayer,
    cycle,
    perform,
    play,
    play_on,
)

__all__ = [
    "AutomatonPlayer",
    "Player",
    "Policy",
    "PolicyPlayer",
    "cycle",
    "perform",
    "play",
    "play_on",
]
