"""The studio: keeps the state of all pages up to date."""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hitab_client import SwarmError, user_name
from hitab_ros.timing import UPDATE_S
from hitab_studio.field.scene import said_message
from hitab_studio.pages.page import Page
from hitab_studio.pages.person_names import checked
from hitab_studio.pages.studio_state import StudioState
from hitab_studio.robots.topics import Options
from hitab_studio.swarm.launcher import NONE
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_link import SwarmLink
from hitab_studio.swarm.swarm_state import SwarmState

KEPT_DIALOGS = frozenset(
    {"help", "label", "name", "release", "rename-recording", "delete-recording"}
)
"""Kinds of dialogs that stay open when the swarm ends."""


class Studio(StudioState):
    """Opens and closes pages, and updates their state from the state of the swarm.

    Args:
        find: returns the swarm to connect to.
        startable: descriptions of the swarms that pages may start, by name.
        choose: switches to another swarm, given its run folder.
        options: the chosen topics of robots.
    """

    def __init__(
        self,
        find: Callable[[], SwarmTarget],
        startable: Mapping[str, str] = NONE,
        choose: Callable[[str], None] = lambda folder: None,
        options: Options | None = None,
    ) -> None:
        super().__init__(SwarmLink(find, self.take, self._complain, choose, options), startable)
        self._orders: dict[str, tuple[int, int]] = {}
        self._place: tuple[object, ...] = ()
        self._replays: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Connect to the swarm and play recordings; to be called in the server's loop."""
        self._replays = asyncio.create_task(self._play())
        self.link.start()

    async def stop(self) -> None:
        """Disconnect and stop playing recordings."""
        if self._replays is not None:
            self._replays.cancel()
        await self.link.stop()

    # -- pages ------------------------------------------------------------------------------

    def open(self, demonstrator: str = "", *, freezes: bool = False) -> Page:
        """Return the state of a new page.

        Args:
            demonstrator: name of the person, from the browser's cookie; the user who runs the
                studio if not a valid name.
            freezes: whether the first key of a behavior pauses the world.
        """
        try:
            name = checked(demonstrator)
        except SwarmError:
            name = user_name()
        page = Page(self, secrets.token_urlsafe(16), name)
        page.time.freezes = freezes
        self.pages[page.id] = page
        return page

    def close(self, page: Page) -> None:
        """Remove a closed page whose requests are finished, and release the page's agents."""
        self.pages.pop(page.id, None)
        for agent in [agent for agent, by in self.held.items() if by is page]:
            del self.held[agent]
        self.touch()

    # -- moments ----------------------------------------------------------------------------

    def take(self, known: SwarmState) -> None:
        """Update all pages to a new state of the swarm."""
        before, self.known = self.known, known
        if known.revision != before.revision:
            self.touch()
        if known.target != before.target:
            self.placements.clear()
            self.snapshots = ()
        if known.scene and before.scene and known.scene.episode != before.scene.episode:
            self.placements.clear()  # they belong to the previous episode
        if (known.target != before.target or known.shown is None) and self.present.roster:
            self._broadcast([self.present.clear()])
        if before.target is not None and known.target != before.target:
            self._close_dialogs(before.target)
        self._forget_former(known)
        scene = known.shown
        moves = scene is not before.shown
        # In a paused world, too, colors show the states of agents and whether they answer.
        does = known.statuses is not before.statuses and scene and scene.mode == "paused"
        falls_silent = known.silent is not before.silent
        messages = []
        if scene is not None and (moves or does or falls_silent):
            if self.present.draw(scene, known.doing()):
                messages.append(self.present.roster)
            if moves and scene.said:
                messages.append(said_message(scene))
        if known.groups is not before.groups:
            messages += map(json.dumps, self._new_orders(known.groups))
        self._broadcast(messages)

    def _forget_former(self, known: SwarmState) -> None:
        """Forget the former swarm once another one is up; a restarted one is the same swarm."""
        target = known.target
        if target is None or target.problem or not (known.scene or known.members):
            return
        for page in self.pages.values():
            page.messages.withdraw(_dialog_closed(target))
        place = (target.domain_id, target.swarm, target.folder)
        if self._place and place != self._place:
            self._orders.clear()
            self.held.clear()
            for page in self.pages.values():
                page.forget_agents()
        self._place = place

    def _close_dialogs(self, target: SwarmTarget) -> None:
        """Close the dialogs about a swarm that has ended."""
        for page in self.pages.values():
            page.missing_targets = page.shown_numbers = None
            if page.dialog and page.dialog["kind"] not in KEPT_DIALOGS:
                page.close_dialog()
                page.tell(_dialog_closed(target), "note")

    def _complain(self, text: str, *, page: str = "", agent: str = "") -> None:
        for one in self.pages.values():
            if page in ("", one.id) and agent in ("", one.agent):
                one.tell(text, "bad")

    def _new_orders(self, groups: Mapping[str, Any]) -> list[dict[str, Any]]:
        found = []
        for name, group in groups.items():
            order = (group.epoch, group.sequence)
            if self._orders.get(name, (0, 0)) != order and group.order:
                self._orders[name] = order
                to = [member.name for member in group.subordinates]
                found.append({"t": "order", "from": name, "order": group.order, "to": to})
        return found

    def _broadcast(self, messages: Sequence[str]) -> None:
        for page in self.pages.values():
            if page.player is None:
                page.outgoing.extend(messages if page.time.past is None else ())
                page.news.set()

    async def _play(self) -> None:
        """Advance the time of open recordings."""
        while True:
            await asyncio.sleep(UPDATE_S)
            for page in list(self.pages.values()):
                try:
                    if page.player is not None and page.player.advance(UPDATE_S):
                        page.show_moment()
                except Exception as error:
                    page.stop_replay(error)


def _dialog_closed(target: SwarmTarget) -> str:
    """Return the message of a page whose dialog was about a swarm that has ended."""
    return f"The dialog was closed: {target.swarm or 'the swarm'} is not there any more."
