"""What a world on an rcssserver tells when it cannot play, or cannot do what it is asked."""

CONNECTING = "connecting to the rcssserver at {}"
BEFORE_PLAY = (
    "the rcssserver at {} has not begun to play; it does so when all players are there, or "
    "server::keepaway_start seconds after its own start"
)
PLAYING_ON = "waiting for the end of the episode that the rcssserver at {} is playing"
JOINED_LATE = (
    "{}; it had begun to play before our players were there, which it does not survive: start it "
    "with server::keepaway_start=-1, so that it waits for them"
)
STOPPED = 'the rcssserver at {} has stopped play ("{}"); start it with server::half_time=-1'
NO_TRAINER = (
    "an rcssserver lets nobody but a trainer put things somewhere; start it with "
    "server::coach_w_referee=1 and this world with parameters.trainer_port:=6001"
)
NO_SNAPSHOT = (
    "the state of an rcssserver cannot be saved or restored: it tells nobody its random numbers "
    "and its referee's counts; use the simulated world for that"
)
