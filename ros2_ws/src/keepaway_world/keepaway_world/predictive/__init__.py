"""Keepers that look ahead: keepaway's vocabulary with what a user would add to it.

- `domain.DOMAIN`: the domain ``keepaway_predictive``; it extends that of `keepaway_world.domain`.
- `body.PredictiveBody`: a keeper's body with a forecast of the ball.
- `forecast`, `lanes`, `behaviors`, `features`: what was added.

Percepts and actions are those of `keepaway_world`: the same worlds can be played in.
"""
