"""The reference players: how UT Austin's keepaway players (Stone et al.) decide.

Written from a study of what these players do on the real simulator, as a yardstick for trained
keepers.

- `view`: a player's estimate of the field. `eyes`: what it sees, remembers and expects.
- `prediction`: what a player expects of its own motion, and the commands that take it somewhere.
- `reaching`: how soon each player can reach the ball, and which is the fastest.
- `interception`: meeting a rolling ball.
- `ball_handling`: kicks in one or several steps, holding the ball.
- `positioning`: getting open for a pass. `marking`: standing in the way of one.
- `policies`: what to do with the ball: hand, rand and hold.
- `takers`: their opponents.

Positions and velocities are complex numbers (x right, y up), angles radians, speeds m/cycle.
"""
