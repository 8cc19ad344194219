"""Keepaway soccer: the world, its referee and takers, and the keepers' body and vocabulary.

- `world.KeepawayWorld`: the simulation, cycle by cycle; `parameters`: all its parameters.
- `domain.DOMAIN`: basic behaviors, features and targets of the keepers; `body.KeeperBody`.
- `percept`, `action`: the layout of what keepers perceive and do.
- `inprocess.play`: whole episodes in one process.

Nothing is imported here, since agents need only the domain, which does not depend on pymunk.
"""
