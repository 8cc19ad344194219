"""Keepers for takers at full speed: they reckon with who is where first.

- `domain.DOMAIN`: the domain ``keepaway_fullspeed``, which extends ``keepaway_predictive``.
- `body.FullSpeedBody`: remembers the last percept, hence velocities, and who was passed to.
- `passing`: how narrowly the takers miss a pass. `supporting`: where a teammate should stand.
- `behaviors`, `features`: the words.

Percepts and actions are those of `keepaway_world`, so the same worlds can be used.
"""
