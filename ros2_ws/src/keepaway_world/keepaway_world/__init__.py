"""Keepaway soccer: the world, its referee and takers, and the keepers' body and vocabulary.

- `world.KeepawayWorld`: the simulation, cycle by cycle; `parameters`: all its parameters.
- `domain.DOMAIN`: basic behaviors, features and targets of the keepers; `body.KeeperBody`.
- `percept`, `action`: the layout of what keepers perceive and do.
- `inprocess.play`: whole episodes in one process.

Modules load when first used, since agents need only the domain, which does not depend on pymunk.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
