"""The studio: what all pages have in common, and what keeps each of them up to date."""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Callable
from typing import Any

from hitab_studio.finding import Target
from hitab_studio.locks import Locks
from hitab_studio.scene import Scene, frame, roster, said_message
from hitab_studio.session import Session
from hitab_studio.store import Store, natural
from hitab_studio.swarm_link import SwarmLink

REPLAY_SECONDS = 0.1


class Studio:
    """The store, the link, and the pages that are open.

    Attributes:
        frame: the last moment as a binary frame.
        frames: how many there were.
        chosen_states: for each agent the automaton that was begun here, and what may be commanded
            in it; nothing: everything.
    """

    def __init__(self, find: Callable[[], Target]) -> None:
        self.store = Store()
        self.locks = Locks()
        self.sessions: dict[str, Session] = {}
        self.link = SwarmLink(self.store, find, self._shown)
        self.chosen_states: dict[str, tuple[str, tuple[str, ...]]] = {}
        self.frame = b""
        self.frames = 0
        self.roster = ""
        self._roster_key: tuple[Any, ...] = ()
        self._orders: dict[str, tuple[int, int]] = {}
        self._numbers = 0
        self._loop: asyncio.AbstractEventLoop | None = None
        self._replays: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Begin; to be called in the server's loop."""
        self._loop = asyncio.get_running_loop()
        self._replays = asyncio.create_task(self._play())
        self.link.start()

    async def stop(self) -> None:
        """End."""
        if self._replays is not None:
            self._replays.cancel()
        await asyncio.to_thread(self.link.stop)

    @staticmethod
    def json(message: Any) -> str:
        """Return a message for a page."""
        return json.dumps(message)

    # -- pages ------------------------------------------------------------------------------

    def open(self) -> Session:
        """Return the session of a new page."""
        self._numbers += 1
        session = Session(self, self._numbers, secrets.token_urlsafe(16))
        self.sessions[session.id] = session
        for other in self.sessions.values():
            other.touch()
        return session

    def close(self, session: Session) -> None:
        """Forget a page that has gone; its agents are free."""
        self.sessions.pop(session.id, None)
        self.locks.leave(session.id)
        self.link.focus(session.id, set())
        self.store.touch()

    def tell(self, session: str, text: str) -> None:
        """Show a message on another page."""
        if (other := self.sessions.get(session)) is not None:
            other.tell(text, "bad")

    def agents(self, session: Session) -> list[str]:
        """Return the agents that a page shows: of the swarm, or of a recording."""
        if session.player is not None:
            return sorted(session.player.recording.statuses(session.player.at), key=natural)
        return self.store.agents

    # -- moments ----------------------------------------------------------------------------

    def _shown(self, scene: Scene) -> None:
        """Take a new moment, in the link's thread."""
        store = self.store
        self.frame = frame(scene, store.doing(), store.palette)
        key = (scene.names, scene.size, len(store.palette.states))
        new_roster = key != self._roster_key
        if new_roster:
            self._roster_key = key
            self.roster = roster(scene, store.palette)
        self.frames += 1
        loop = self._loop
        if loop is not None and not loop.is_closed():
            said = said_message(scene) if scene.said else ""
            loop.call_soon_threadsafe(self._spread, new_roster, said, self._new_orders())

    def _new_orders(self) -> list[dict[str, Any]]:
        found = []
        for name, group in self.store.groups.items():
            order = (group.epoch, group.sequence)
            if self._orders.get(name, (0, 0)) != order and group.order:
                self._orders[name] = order
                found.append(
                    {
                        "t": "order",
                        "from": name,
                        "order": group.order,
                        "to": list(group.subordinates),
                    }
                )
        return found

    def _spread(self, new_roster: bool, said: str, orders: list[dict[str, Any]]) -> None:
        for session in self.sessions.values():
            if session.player is not None:
                continue
            if new_roster:
                session.outgoing.append(self.roster)
            if said:
                session.outgoing.append(said)
            for order in orders:
                session.outgoing.append(self.json(order))
            session.news.set()

    def show_again(self, session: Session) -> None:
        """Show the present moment: of the recording that is open, else of the swarm."""
        if session.player is not None:
            self.show_moment(session)
        elif self.roster:
            session.outgoing.append(self.roster)
        session.news.set()

    def show_moment(self, session: Session) -> None:
        """Show the moment of the recording at which a page is."""
        player = session.player
        if player is None:
            return
        scene = player.recording.scene(player.at)
        session.outgoing.append(roster(scene, self.store.palette))
        if scene.said:
            session.outgoing.append(said_message(scene))
        session.news.set()
        session.touch()

    def frame_for(self, session: Session) -> bytes:
        """Return the frame that a page is to show now."""
        if session.player is None:
            return self.frame
        recording, at = session.player.recording, session.player.at
        return frame(recording.scene(at), recording.doing(at), self.store.palette)

    async def _play(self) -> None:
        """Let the time of open recordings pass."""
        while True:
            await asyncio.sleep(REPLAY_SECONDS)
            for session in list(self.sessions.values()):
                if session.player is not None and session.player.advance(REPLAY_SECONDS):
                    self.show_moment(session)
