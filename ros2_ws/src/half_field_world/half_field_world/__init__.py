"""Half-field attack: three attackers against two defenders and a goalie.

- `game.half_field`: the world, with its rules; `parameters`; `field`; `defence`: the opponents.
- `domain.DOMAIN`: the attackers' words, which are the keepers' and a few more; `body`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
