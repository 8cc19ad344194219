"""All clients that we have on one server: they are told a cycle together and answer together."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from keepaway_world.rcss.connection import (
    Connection,
    NoAnswer,
    ServerError,
    connect,
    readable,
)
from keepaway_world.rcss.messages import (
    BEFORE_KICK_OFF,
    EPISODE_OVER,
    LEFT,
    OUR,
    REFEREE,
    RIGHT,
    FullState,
    Hear,
    Init,
    Parameters,
    See,
    SenseBody,
    Think,
)
from keepaway_world.rcss.reading import parse_message
from keepaway_world.rcss.server_settings import FULL_STATE, ServerSettings
from keepaway_world.rcss.sexpr import ProtocolError
from keepaway_world.rcss.sighting import Sighting, together

PARAMETERS_SECONDS = 1.0  # for the server's settings, which follow the answer to (init ...)
STRAGGLER_SECONDS = 0.3  # a client that still has nothing when others have it has lost it
REPEAT_SECONDS = 0.4  # after so much silence the server is told (done) again
GONE_SECONDS = 4.0  # a server waits 1.25 s for a (done): one that takes longer is gone
REALTIME_STRAGGLER_SECONDS = 0.02


@dataclass
class Client:
    """One of our players, and what it was told of this cycle.

    Attributes:
        told: whether it was told anything of it yet.
        thinking: whether the server waits for its ``(done)``.
        time: of the cycle, the server's.
        heard: from its team mates.
        sighting: what it makes of what it sees; None if that is not looked at.
    """

    connection: Connection
    told: bool = False
    thinking: bool = False
    time: int = -1
    heard: list[str] = field(default_factory=list)
    sighting: Sighting | None = None


class Link:
    """Our players on a server.

    Attributes:
        clients: by name, keepers first.
        settings: the server's own.
        synch: whether the server waits for ``(done)``; else it plays in real time.
        full_state: whether the server tells everything as it is.
        mode: of play, as far as it was told.
        time: the server's, in cycles, as far as it was told.
        referee: what the referee said in this cycle, with the server's time.
        thinking_since: when the server last began to wait for us.
    """

    def __init__(self, server: ServerSettings, keepers: int, takers: int) -> None:
        """Have the server take in all players, the keepers first: the first team is left.

        Raises:
            NoAnswer: if there is no server.
            ServerError: if it refuses, or plays something else.
        """
        self.where = server.where
        self.clients: dict[str, Client] = {}
        self.settings = Parameters("server_param", {})
        self.time = -1
        self.referee: set[tuple[int, str]] = set()
        self.thinking_since = self._last_arrival = 0.0
        self._state_text = ""
        self.synch = False
        self.full_state = True
        self.mode = BEFORE_KICK_OFF
        try:
            for kind, team, count in (
                ("keeper", server.team, keepers),
                ("taker", server.taker_team, takers if server.our_takers else 0),
            ):
                for index in range(count):
                    client = Client(connect(server.host, server.port, team))
                    self.clients[f"{kind}_{index + 1}"] = client
                    self._check(kind, index, client.connection.init)
            self._await_settings()
            self._check_settings(server)
            self._open_eyes(server)
        except BaseException:
            self.close()
            raise

    def _check(self, kind: str, index: int, init: Init) -> None:
        if init.side == (LEFT if kind == "keeper" else RIGHT) and init.number != index + 1:
            raise ServerError(
                f"on the rcssserver at {self.where} others are the {kind}s, or have been until "
                "they left, after which nobody can take their place; start the server anew"
            )
        if init.side != (LEFT if kind == "keeper" else RIGHT):
            raise ServerError(
                f"on the rcssserver at {self.where} the {kind}s are the wrong team: another team "
                "was there first; the first one to connect are the keepers, so start the server "
                "anew and this world before any takers"
            )

    def _check_settings(self, server: ServerSettings) -> None:
        self.synch = self.settings.number("synch_mode", 0.0) != 0.0
        self.full_state = self.settings.number("fullstate_l", 0.0) != 0.0
        if not self.settings.number("keepaway", 0.0):
            raise ServerError(
                f"the rcssserver at {self.where} plays a whole match; "
                "start it with server::keepaway=1"
            )
        if not self.full_state and server.percepts == FULL_STATE:
            raise ServerError(
                f"the rcssserver at {self.where} does not tell the keepers its full state; start "
                "it with server::fullstate_l=1, or set the parameter percepts to see"
            )

    def _open_eyes(self, server: ServerSettings) -> None:
        """Have those players see in every cycle whose sight is looked at."""
        teams = {server.team: LEFT, server.taker_team: RIGHT}
        decay = self.settings.number("ball_decay", 0.94)
        speed_max = self.settings.number("ball_speed_max", 3.0)
        for name, client in self.clients.items():
            init = client.connection.init
            if self.full_state and (server.percepts == FULL_STATE or init.side == RIGHT):
                continue
            me = init.side, init.number
            self.clients[name].sighting = Sighting(me, teams, decay, speed_max)
            # Otherwise it would see in two cycles of three, half as far round again.
            client.connection.send("(synch_see)", "(change_view narrow high)")

    @property
    def joined_late(self) -> bool:
        """Whether the server had begun to play before all of our players were there."""
        return any(c.connection.init.mode != BEFORE_KICK_OFF for c in self.clients.values())

    def _await_settings(self) -> None:
        deadline = time.monotonic() + PARAMETERS_SECONDS
        while not self.settings.values:
            left = deadline - time.monotonic()
            if left <= 0.0:
                raise NoAnswer(f"the rcssserver at {self.where} does not tell its settings")
            self.poll(left)

    def close(self) -> None:
        """Take our players out of the game."""
        for client in self.clients.values():
            client.connection.close()

    # -- what the server tells ----------------------------------------------------------------

    def poll(self, seconds: float = 0.0) -> None:
        """Take in what arrives within so many seconds; return as soon as something has.

        Raises:
            NoAnswer: if the server is gone.
        """
        by_connection = {client.connection: client for client in self.clients.values()}
        for connection in readable(by_connection, seconds):
            client = by_connection[connection]
            for text in connection.receive():
                self._last_arrival = time.monotonic()
                self._take(client, text)

    def _take(self, client: Client, text: str) -> None:
        if text.startswith("(fullstate "):  # all get the same: one of them is read, later
            self._state_text = text
            return
        if text.startswith("(see ") and client.sighting is None:
            return
        message = client.connection.parse(text)
        if isinstance(message, Think):
            client.thinking = True
            self.thinking_since = self._last_arrival
        elif isinstance(message, SenseBody):
            client.told = True
            client.time = message.time
            self.time = max(self.time, message.time)
            if client.sighting is not None:
                client.sighting.feel(message)
        elif isinstance(message, See):
            if client.sighting is not None:
                client.sighting.see(message)
        elif isinstance(message, Hear):
            if message.sender == REFEREE:
                self.referee.add((message.time, message.text))
                if message.text != EPISODE_OVER:
                    self.mode = message.text
            elif message.team == OUR:
                client.heard.append(message.text)
        elif isinstance(message, Parameters) and message.kind == "server_param":
            self.settings = message

    def state(self) -> FullState | None:
        """Return the newest full state, None if none has arrived since `forget`.

        Where the server tells none, it is what our players see together.
        """
        if not self.full_state:
            eyes = (c.sighting for c in self.clients.values() if c.sighting is not None)
            return together(eyes, self.mode)
        try:
            message = parse_message(self._state_text) if self._state_text else None
        except ProtocolError:
            return None
        return message if isinstance(message, FullState) else None

    def forget(self) -> None:
        """Forget what was told of this cycle."""
        self._state_text = ""
        self.referee.clear()
        for client in self.clients.values():
            client.heard.clear()
            client.told = False

    # -- answering ----------------------------------------------------------------------------

    def answer(self, commands: Mapping[str, Sequence[str]]) -> None:
        """Have our players give their commands, by name.

        Raises:
            NoAnswer: if the server is gone.
        """
        for name, client in self.clients.items():
            client.thinking = False
            client.connection.send(*commands.get(name, ()), *self._done)

    @property
    def _done(self) -> tuple[str, ...]:
        return ("(done)",) if self.synch else ()

    @property
    def complete(self) -> bool:
        """Whether all of our players were told of a cycle and can act in it."""
        clients = self.clients.values()
        if self.synch:  # (think) comes last
            return all(c.told and c.time == self.time and c.thinking for c in clients)
        if self.full_state and not self._state_text:
            return False
        return all(
            c.told and c.time == self.time and (c.sighting is None or c.sighting.time == self.time)
            for c in clients
        )

    @property
    def _incomplete(self) -> bool:
        """Whether some of our players can act in a new cycle, as far as they were told."""
        if self.synch:
            return any(client.thinking for client in self.clients.values())
        return any(client.told for client in self.clients.values())

    def await_cycle(self) -> None:
        """Wait until our players can act in the next cycle; datagrams may be lost.

        Raises:
            NoAnswer: if the server is silent for longer than it can be.
        """
        began = repeated = time.monotonic()
        straggler = STRAGGLER_SECONDS if self.synch else REALTIME_STRAGGLER_SECONDS
        some_since = 0.0
        while not self.complete:
            now = time.monotonic()
            if now - began > GONE_SECONDS:
                raise NoAnswer(
                    f"the rcssserver at {self.where} has not gone on for {GONE_SECONDS:g} s; "
                    "start it again"
                )
            if self._incomplete:
                some_since = some_since or now
                if now - some_since > straggler:
                    return  # what the others lack was lost
            elif self.synch and now - repeated > REPEAT_SECONDS:
                repeated = now  # the server may not have got it
                for client in self.clients.values():
                    client.connection.send("(done)")
            self.poll(min(straggler, 0.1))
