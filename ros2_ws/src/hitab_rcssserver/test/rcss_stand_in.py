"""Stands in for rcssserver in tests: answers from the transcript, over real sockets."""

import contextlib
import gzip
import json
import re
import select
import socket
import threading
import time
from pathlib import Path

TRANSCRIPT = Path(__file__).parent / "data" / "keepaway_transcript.jsonl.gz"
HALF_FIELD = TRANSCRIPT.with_name("half_field_transcript.jsonl.gz")
KEEPER, TAKER = 0, 3  # whose messages a transcript holds


def transcript(path=TRANSCRIPT):
    """Return the lines of a transcript."""
    with gzip.open(path, "rt") as lines:
        return [json.loads(line) for line in lines]


def rounds(lines, client):
    """Return what a client was sent: at first, and then before each of its answers."""
    told = [[]]
    for line in lines:
        if line["client"] == client and line["dir"] == "recv":
            told[-1].append(line["msg"])
            if line["msg"].startswith(("(think)", "(player_type (id 17)")):
                told.append([])
    if not told[-1]:
        return told[:-1]
    # Keepaway's recording stops at the last episode's end; the next one begins like the first.
    last = told[-1][0].split()[1]
    first = next(r for r in told if any("referee play_on" in text for text in r))
    told[-1] += [re.sub(r"^(\(\w+) 0 ", rf"\1 {last} ", text) for text in first[1:]]
    return told


class StandIn:
    """A server on a free port of this machine that replays the transcript to any keepers.

    All keepers receive what the transcript's keeper received, all takers what its taker did:
    a round when everybody has answered the one before with ``(done)``.

    Args:
        path: of the transcript.
        port: to be at; 0 for any free one.
        players: how many must be there before it begins to play.
        version: the only protocol version that it speaks.
        lose: called with the message and the client's number; whether it is lost on the way.
        edit: changes the text of a message.
        synch: whether it waits for answers, else it goes on by itself, ten times as fast as life.
        begun: whether it begins to play by itself; else a monitor has to tell it to.
    """

    def __init__(
        self,
        port=0,
        players=5,
        version=15,
        lose=None,
        edit=lambda text: text,
        synch=True,
        begun=True,
        path=TRANSCRIPT,
    ):
        self.players, self.version, self.edit, self.synch = players, version, edit, synch
        self.begun = begun
        self.lose = lose or (lambda text, number: False)
        self.received = []
        self.errors = []
        self.silent = False
        lines = transcript(path)
        self._told = {"l": rounds(lines, KEEPER), "r": rounds(lines, TAKER)}
        if players:
            self._told["l"].pop(1)  # its client was there a round before the others
        self._init = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._init.bind(("127.0.0.1", port))
        self.port = self._init.getsockname()[1]
        self._monitor = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._monitor.bind(("127.0.0.1", 0))
        self._trainer = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._trainer.bind(("127.0.0.1", 0))
        self.trainer_port = self._trainer.getsockname()[1]
        self.moves = []
        self.goalies = []  # which of the players asked to be one
        self._clients = []  # [socket, address, side, number, done]
        self._round = 0
        self._due = 0.0
        self._told_at = 0.0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self.stop()

    def stop(self):
        """Go away, as when the process ends."""
        self._stop.set()
        self._thread.join(5.0)
        for sock in (
            self._init,
            self._monitor,
            self._trainer,
            *(client[0] for client in self._clients),
        ):
            sock.close()

    def commands(self, number=None):
        """Return all commands but ``(done)``, of one client or of all."""
        return [
            text for sender, text in self.received if number in (None, sender) and text != "(done)"
        ]

    def _run(self):
        try:
            while not self._stop.is_set():
                socks = [
                    self._init,
                    self._monitor,
                    self._trainer,
                    *(client[0] for client in self._clients),
                ]
                for sock in select.select(socks, [], [], 0.01)[0]:
                    with contextlib.suppress(OSError):
                        data, address = sock.recvfrom(8192)
                        self._take(sock, data, address)
                if not self.silent:
                    self._go_on()
        except Exception as error:  # to be found by the test
            self.errors.append(error)

    def _take(self, sock, data, address):
        assert data.endswith(b"\0"), data
        text = data.decode().rstrip("\0")
        if sock is self._init:
            self._take_in(text, address)
            return
        if sock is self._trainer:
            self._train(text, address)
            return
        if sock is self._monitor:
            self.begun = self.begun or text == "(dispstart)"
            return
        number = next(i for i, client in enumerate(self._clients) if client[0] is sock)
        if self.lose(text, number):
            return
        self.received.append((number, text))
        if text == "(done)":
            self._clients[number][4] = True

    def _train(self, text, address):
        command = text.strip("()").split()[0]
        if command == "move":
            self.moves.append(text)
        self.begun = self.begun or text == "(change_mode play_on)"
        answer = "(init ok)" if command == "init" else f"(ok {command})"
        self._trainer.sendto(answer.encode() + b"\0", address)

    def _take_in(self, text, address):
        if text.startswith("(dispinit"):
            self._monitor.sendto(b"(server_param (keepaway 1))\0", address)
            return
        self.goalies.append("(goalie)" in text)
        if f"(version {self.version})" not in text:
            self._init.sendto(
                b"(error no_more_player_or_goalie_or_illegal_client_version)\0", address
            )
            return
        team = text.split()[1]
        teams = list(dict.fromkeys(client[5] for client in self._clients))
        side = "l" if not teams or team == teams[0] else "r"
        number = sum(client[5] == team for client in self._clients) + 1
        sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sock.bind(("127.0.0.1", 0))
        self._clients.append([sock, address, side, number, True, team])
        for message in self._told[side][0]:
            if message.startswith("(init"):
                message = f"(init {side} {number} before_kick_off)"
            self._send(len(self._clients) - 1, message)

    def _go_on(self):
        now = time.monotonic()
        if len(self._clients) < self.players or not self._clients:
            return
        if not self.synch:
            if now < self._due:
                return
            self._due = now + 0.01
        elif not all(client[4] for client in self._clients) and now - self._told_at < 1.25:
            return
        self._round += self.begun or self._round == 0  # before that, the first one again
        self._told_at = now
        for number, client in enumerate(self._clients):
            told = self._told[client[2]]
            if self._round < len(told):
                client[4] = False
                for message in told[self._round]:
                    if self.synch or message != "(think)":
                        self._send(number, message)

    def _send(self, number, message):
        sock, address, *_ = self._clients[number]
        if not self.lose(message, number):
            sock.sendto(self.edit(message).encode() + b"\0", address)
