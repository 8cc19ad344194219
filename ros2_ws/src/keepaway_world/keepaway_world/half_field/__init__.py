"""Half-field attack: three attackers against two defenders and a goalie.

- `game.half_field`: the world, with its rules; `parameters`; `field`; `defence`: the opponents.
- `domain.DOMAIN`: the attackers' words, which are the keepers' and a few more; `body`.
"""
