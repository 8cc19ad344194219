"""Keepers that look ahead: keepaway's vocabulary with a user's additions.

- `domain.DOMAIN`: the domain ``keepaway_predictive``; it extends that of `keepaway_world.domain`.
- `body.PredictiveBody`: a keeper's body with a forecast of the ball.
- `forecast`, `lanes`, `behaviors`, `features`: what was added.

Percepts and actions are those of `keepaway_world`, so the same worlds can be used.
"""
