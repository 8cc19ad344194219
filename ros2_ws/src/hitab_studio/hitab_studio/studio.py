"""The studio: what all pages have in common, and what keeps each of them up to date.

All of it belongs to the server's thread: the studio, the store, the sessions. What the link's
thread knows comes through a mailbox, frozen (`swarm_link.py` has the rule).
"""

from __future__ import annotations

import asyncio
import json
import logging
import secrets
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hitab_ros.answering import what_went_wrong
from hitab_studio.finding import Target
from hitab_studio.known import Known, Trouble, natural
from hitab_studio.locks import Locks
from hitab_studio.mailbox import Mailbox
from hitab_studio.scene import Scene, frame, roster, said_message
from hitab_studio.session import Session
from hitab_studio.store import Store
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
        self.link = SwarmLink(find, self._hear)
        self.chosen_states: dict[str, tuple[str, tuple[str, ...]]] = {}
        self.frame = b""
        self.frames = 0
        self.roster = ""
        self._roster_key: tuple[Any, ...] = ()
        self._orders: dict[str, tuple[int, int]] = {}
        self._numbers = 0
        self._painted = 0
        self._mailbox: Mailbox[Known | Trouble] | None = None
        self._replays: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Begin; to be called in the server's loop."""
        self._mailbox = Mailbox(asyncio.get_running_loop(), self._take)
        self._replays = asyncio.create_task(self._play())
        self.link.start()

    async def stop(self) -> None:
        """End."""
        if self._replays is not None:
            self._replays.cancel()
        await asyncio.to_thread(self.link.stop)

    def _hear(self, news: Known | Trouble) -> None:
        """Take what the link tells; in the link's thread."""
        if self._mailbox is not None:
            self._mailbox.post(news)

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
        """Forget a page that has gone, and is doing nothing any more; its agents are free."""
        self.sessions.pop(session.id, None)
        self.locks.leave(session.id)
        self.link.focus(session.id, [])
        self.store.touch()

    def tell(self, session: str, text: str) -> None:
        """Show a message on another page."""
        if (other := self.sessions.get(session)) is not None:
            other.tell(text, "bad")

    def agents(self, session: Session) -> list[str]:
        """Return the agents that a page shows: of the swarm, or of a recording."""
        if session.player is not None:
            return sorted(session.player.recording.statuses(session.player.at), key=natural)
        return self.store.known.agents

    # -- moments ----------------------------------------------------------------------------

    def _take(self, news: Sequence[Known | Trouble]) -> None:
        """Take what the link tells: what is known now, and what went wrong."""
        for trouble in news:
            if isinstance(trouble, Trouble):
                self._complain(trouble)
        told = [known for known in news if isinstance(known, Known)]
        if not told:
            return
        before, known = self.store.known, told[-1]
        self.store.take(known)
        scene = known.scene
        moves = scene is not before.scene
        # What agents do is shown in the field of a paused world too.
        does = known.statuses is not before.statuses
        messages = []
        if scene is not None and (moves or (does and scene.mode == "paused")):
            if self._draw(scene):
                messages.append(self.roster)
            seen = {id(k.scene): k.scene for k in told if k.scene is not before.scene}
            messages += [said_message(s) for s in seen.values() if s is not None and s.said]
            self._spread(messages)
        self._spread([self.json(order) for order in self._new_orders(known.groups)])

    def _complain(self, trouble: Trouble) -> None:
        for session in self.sessions.values():
            if trouble.session in ("", session.id) and trouble.agent in ("", session.agent):
                session.tell(trouble.text, "bad")

    def _draw(self, scene: Scene) -> bool:
        """Make the frame of a moment; return whether the roster has changed."""
        palette = self.store.palette
        self.frame = frame(scene, self.store.known.doing(), palette)
        self.frames += 1
        if len(palette.states) != self._painted:
            self._painted = len(palette.states)
            self.link.paint(palette.colors())
        key = (scene.names, scene.size, len(palette.states))
        if key == self._roster_key:
            return False
        self._roster_key = key
        self.roster = roster(scene, palette)
        return True

    def _new_orders(self, groups: Mapping[str, Any]) -> list[dict[str, Any]]:
        found = []
        for name, group in groups.items():
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

    def _spread(self, messages: Sequence[str]) -> None:
        for session in self.sessions.values():
            if session.player is None:
                session.outgoing.extend(messages)
                session.news.set()

    def show_again(self, session: Session) -> None:
        """Show the present moment: of the recording that is open, else of the swarm.

        The page gets it even if it was sent before: it may show something else by now.
        """
        session.sent = b""
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
                try:
                    if session.player is not None and session.player.advance(REPLAY_SECONDS):
                        self.show_moment(session)
                except Exception as error:
                    self.stop_replay(session, error)

    def stop_replay(self, session: Session, error: Exception) -> None:
        """Close a recording that cannot be shown, and tell why."""
        logging.getLogger(__name__).error("a recording", exc_info=error)
        session.player = None
        session.tell(f"This recording cannot be shown further: {what_went_wrong(error)}", "bad")
        self.show_again(session)
