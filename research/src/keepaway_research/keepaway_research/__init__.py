"""Keepaway beyond the game itself: what serves the project's own figures.

- `reference`: UT Austin's keepers and takers, offered as ``keepaway.keepers`` and
  ``keepaway.takers``.
- `predictive`, `fullspeed`: the domains of keepers that look ahead, and of keepers for takers at
  full speed.

Their swarms, lessons and libraries are beside this package, as in `keepaway_world`.
"""
