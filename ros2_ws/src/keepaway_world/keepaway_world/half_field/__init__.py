"""Half-field attack: three attackers against two defenders and a goalie.

- `game.RULES`: where a game of `keepaway_world.world.KeepawayWorld` begins and when it ends;
  `parameters`; `defence`: the opponents.
- `domain.DOMAIN`: the attackers' words, which are the keepers' and a few more.
- `rule_based`: attackers that are written by hand in these words, and random ones.
"""
