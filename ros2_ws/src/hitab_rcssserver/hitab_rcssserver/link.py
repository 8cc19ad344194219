"""The link to a server: all our clients, which handle each cycle together."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from hitab_rcssserver.connection import (
    NoAnswer,
    ServerConnection,
    ServerError,
    connect,
    parsed,
    readable,
)
from hitab_rcssserver.messages import (
    BEFORE_KICK_OFF,
    EPISODE_OVER,
    LEFT,
    OUR,
    REFEREE,
    RIGHT,
    FullState,
    Hear,
    Init,
    See,
    SenseBody,
    Settings,
    Think,
)
from hitab_rcssserver.server_settings import FULL_STATE, ServerSettings
from hitab_rcssserver.sighting import Sighting, Who, together
from hitab_ros.timing import REPEAT_S, TURN_S
from keepaway_world.game.physics import Names

GOALIE = "goalie"
"""Name of the player that may catch the ball."""

SERVER_WAIT_S = 1.25
"""Time for which a server waits for a ``(done)``, s: shorter waits of ours are parts of it, and a
server that is silent for three times as long has gone."""


@dataclass
class Client:
    """One of our players, and its messages in this cycle.

    Attributes:
        informed: whether the player has received a message in this cycle.
        thinking: whether the server waits for its ``(done)``.
        time: the cycle, in the server's count.
        heard: messages from the player's teammates.
        sighting: interprets the player's sight; None if its sight is not used.
    """

    connection: ServerConnection
    informed: bool = False
    thinking: bool = False
    time: int = -1
    heard: list[str] = field(default_factory=list)
    sighting: Sighting | None = None


class Link:
    """Our players on a server.

    Attributes:
        clients: by name, the left team first.
        settings: the server's own settings.
        synch: whether the server waits for ``(done)``; else it plays in real time.
        full_state: whether the server reports the full state.
        mode: the play mode, as last reported.
        time: the server's time in cycles, as last reported.
        referee: the referee's messages of this cycle, with the server's time.
        thinking_since: when the server last started to wait for us.
    """

    def __init__(self, server: ServerSettings, names: Names, *, keepaway: bool) -> None:
        """Register all players, the keepers first, since the first team is left.

        Args:
            server: address of the server, and the teams.
            names: names of the keepers and the takers.
            keepaway: whether the server plays keepaway itself, instead of a match.

        Raises:
            NoAnswer: if there is no server.
            ServerError: if the server refuses, or plays another game.
        """
        self.where = server.where
        self.clients: dict[str, Client] = {}
        self.settings = Settings({})
        self.time = -1
        self.referee: set[tuple[int, str]] = set()
        self.thinking_since = 0.0
        self._states: dict[str, str] = {}
        self.synch = False
        self.full_state = True
        self.mode = BEFORE_KICK_OFF
        try:
            for side, team, players in (
                (LEFT, server.team, names[0]),
                (RIGHT, server.taker_team, names[1] if server.our_takers else ()),
            ):
                for index, name in enumerate(players):
                    client = Client(connect(server.host, server.port, team, goalie=name == GOALIE))
                    self.clients[name] = client
                    self._check((side, index + 1), client.connection.init)
            self._await_settings()
            self._check_settings(server, keepaway)
            self._open_eyes(server)
        except BaseException:
            self.close()
            raise

    def _check(self, who: Who, init: Init) -> None:
        if (init.side, init.number) != who:
            kind = "keepers" if who[0] == LEFT else "takers"
            raise ServerError(
                f"on the rcssserver at {self.where} other clients are, or were, the {kind}, or "
                "connected first, which makes them the keepers; players that leave cannot be "
                "replaced: restart the server, and start this world before any takers"
            )

    def _check_settings(self, server: ServerSettings, keepaway: bool) -> None:
        self.synch = self.settings.number("synch_mode", 0.0) != 0.0
        self.full_state = self.settings.number("fullstate_l", 0.0) != 0.0
        if bool(self.settings.number("keepaway", 0.0)) != keepaway:
            plays = "a whole match" if keepaway else "keepaway"
            raise ServerError(
                f"the rcssserver at {self.where} plays {plays}; "
                f"start it with server::keepaway={keepaway:d}"
            )
        if not self.full_state and server.percepts == FULL_STATE:
            raise ServerError(
                f"the rcssserver at {self.where} does not send the keepers its full state; start "
                "it with server::fullstate_l=1, or set the parameter percepts to see"
            )

    def _open_eyes(self, server: ServerSettings) -> None:
        """Make the players whose sight is used see in every cycle."""
        teams = {server.team: LEFT, server.taker_team: RIGHT}
        decay = self.settings.number("ball_decay", 0.94)
        speed_max = self.settings.number("ball_speed_max", 3.0)
        for client in self.clients.values():
            init = client.connection.init
            if self.full_state and (server.percepts == FULL_STATE or init.side == RIGHT):
                continue
            client.sighting = Sighting((init.side, init.number), teams, decay, speed_max)
            # By default, a player sees in two cycles of three, at a wider angle.
            client.connection.send("(synch_see)", "(change_view narrow high)")

    @property
    def joined_late(self) -> bool:
        """Whether the server started to play before all of our players had joined."""
        return any(c.connection.init.mode != BEFORE_KICK_OFF for c in self.clients.values())

    def _await_settings(self) -> None:
        deadline = time.monotonic() + REPEAT_S
        while not self.settings.values:
            left = deadline - time.monotonic()
            if left <= 0.0:
                raise NoAnswer(f"the rcssserver at {self.where} sends no settings; restart it")
            self.poll(left)

    def close(self) -> None:
        """Take our players out of the game."""
        for client in self.clients.values():
            client.connection.close()

    # -- messages of the server --------------------------------------------------------------

    def poll(self, seconds: float = 0.0) -> None:
        """Handle the messages that arrive within ``seconds``; return after the first ones.

        Raises:
            NoAnswer: if the server is gone.
        """
        by_connection = {client.connection: client for client in self.clients.values()}
        for connection in readable(by_connection, seconds):
            client = by_connection[connection]
            for text in connection.receive():
                self._take(client, text)

    def _take(self, client: Client, text: str) -> None:
        if text.startswith("(fullstate "):  # all clients get the same: one copy is read, later
            self._states[text.split(" ", 2)[1]] = text
            return
        if text.startswith("(see ") and client.sighting is None:
            return
        match message := parsed(text):
            case Think():
                client.thinking = True
                self.thinking_since = time.monotonic()
            case SenseBody():
                client.informed = True
                client.time = message.time
                self.time = max(self.time, message.time)
                if client.sighting is not None:
                    client.sighting.feel(message)
            case See() if client.sighting is not None:
                client.sighting.see(message)
            case Hear(sender=sender) if sender == REFEREE:
                self.referee.add((message.time, message.text))
                if message.text != EPISODE_OVER:
                    self.mode = message.text
            case Hear(team=team) if team == OUR:
                client.heard.append(message.text)
            case Settings():
                self.settings = message

    def states(self) -> list[FullState]:
        """Return the full state of each cycle since `forget`; there are several if we were late.

        If the server sends no full state, the states are combined from our players' sight.
        """
        if not self.full_state:
            eyes = (c.sighting for c in self.clients.values() if c.sighting is not None)
            seen = together(eyes, self.mode)
            return [] if seen is None else [seen]
        return [m for m in map(parsed, self._states.values()) if isinstance(m, FullState)]

    def forget(self) -> None:
        """Clear the messages of this cycle."""
        self._states.clear()
        self.referee.clear()
        for client in self.clients.values():
            client.heard.clear()
            client.informed = False

    # -- answering ----------------------------------------------------------------------------

    def answer(self, commands: Mapping[str, Sequence[str]]) -> None:
        """Send our players' commands, by name.

        Raises:
            NoAnswer: if the server is gone.
        """
        for name, client in self.clients.items():
            client.thinking = False
            client.connection.send(*commands.get(name, ()), *["(done)"] * self.synch)

    @property
    def complete(self) -> bool:
        """Whether all of our players have received a cycle's messages and can act in it."""
        clients = self.clients.values()
        if self.synch:  # (think) comes last
            return all(c.informed and c.time == self.time and c.thinking for c in clients)
        if self.full_state and not self._states:
            return False
        return all(
            c.informed
            and c.time == self.time
            and (c.sighting is None or c.sighting.time == self.time)
            for c in clients
        )

    def await_cycle(self) -> None:
        """Wait until our players can act in the next cycle; datagrams may be lost.

        Raises:
            NoAnswer: if the server is silent for longer than a running server can be.
        """
        began = repeated = time.monotonic()
        # Then a message that only other clients got counts as lost.
        straggler = SERVER_WAIT_S / 4 if self.synch else 2 * TURN_S
        some_since = 0.0
        while not self.complete:
            now = time.monotonic()
            if now - began > 3 * SERVER_WAIT_S:
                raise NoAnswer(
                    f"the rcssserver at {self.where} has been silent for {3 * SERVER_WAIT_S:g} s; "
                    "start it again"
                )
            if any(c.thinking if self.synch else c.informed for c in self.clients.values()):
                some_since = some_since or now
                if now - some_since > straggler:
                    return  # the others' messages were lost
            elif self.synch and now - repeated > SERVER_WAIT_S / 3:
                repeated = now  # the server may not have got it
                for client in self.clients.values():
                    client.connection.send("(done)")
            self.poll(min(straggler, 0.1))
