"""Keepaway soccer: the world, its referee and takers, and the keepers' body and vocabulary.

- `world.KeepawayWorld`: the simulation, cycle by cycle; `parameters`: all its figures.
- `domain.DOMAIN`: basic behaviors, features and targets of the keepers; `body.KeeperBody`.
- `percept`, `action`: the layout of what keepers perceive and do.
- `inprocess.play`: whole episodes in one process.

Agents need the domain alone, which is why nothing is imported here: it does without pymunk.
"""
