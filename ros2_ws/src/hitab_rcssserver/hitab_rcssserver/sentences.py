"""Error texts of a world on an rcssserver."""

CONNECTING = "connecting to the rcssserver at {}"
BEFORE_PLAY = (
    "the rcssserver at {} has not begun to play; it begins when all players have joined, or "
    "server::keepaway_start seconds after its own start"
)
PLAYING_ON = "waiting for the end of the episode that the rcssserver at {} is playing"
JOINED_LATE = (
    "{}; it began to play before our players had joined, and such a server crashes: start it "
    "with server::keepaway_start=-1, so that it waits for them"
)
SERVER_STOPPED = 'the rcssserver at {} has stopped play ("{}"); start it with server::half_time=-1'
NO_TRAINER = (
    "an rcssserver lets only a trainer move things; start it with "
    "server::coach_w_referee=1 and this world with parameters.trainer_port:=6001"
)
NO_SNAPSHOT = (
    "the state of an rcssserver cannot be saved or restored: it reveals neither its random "
    "numbers nor its referee's counts; use the simulated world for that"
)
