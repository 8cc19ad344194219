"""Recording runs, and replaying them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

from hitab_client import SwarmError
from hitab_client.recording import recordings
from hitab_studio.actions.registry import Data, action
from hitab_studio.page_state import PageState
from hitab_studio.replay import Recording, ReplayPlayer

T = TypeVar("T")


@action("record")
async def record(session: PageState, data: Data) -> None:
    """Record the run, or stop recording."""
    link, store = session.shared.link, session.shared.store

    async def stop() -> str:
        return link.observer.stop_recording()

    async def start() -> None:
        link.observer.start_recording(path, session.id)

    if store.known.recording:
        session.tell(f"Recorded to {await session.ask(lambda _: stop())}")
    else:
        path = str(
            recordings.new_recording(store.known.target.swarm if store.known.target else "")
        )
        await session.ask(lambda _: start())
    session.tab = "record"


@action("replay")
async def replay(session: PageState, data: Data) -> None:
    """Open a recording."""
    path = recordings.recording(str(data["name"]))
    session.player = ReplayPlayer(await meanwhile_busy(session, lambda: Recording(path)))
    if session.player.recording.missing:
        session.tell(session.player.recording.missing)
    session.show_again()


@action("recording-rename")
async def rename(session: PageState, data: Data) -> None:
    """Give a recording another name."""
    name = session.dialog["name"]
    _not_being_recorded(session, name)
    path = recordings.rename(name, str(data["values"].get("name", "")))
    session.close_dialog()
    session.tell(f"{name} is called {path.name} now")


@action("recording-delete")
async def delete(session: PageState, data: Data) -> None:
    """Delete a recording."""
    name = session.dialog["name"]
    _not_being_recorded(session, name)
    recordings.delete(name)
    session.close_dialog()
    session.tell(f"{name} is deleted")


def _not_being_recorded(session: PageState, name: str) -> None:
    if session.shared.store.known.recording.endswith(f"/{name}"):
        raise SwarmError(f"{name} is being recorded: stop that first.")


@action("replay-play")
async def replay_play(session: PageState, data: Data) -> None:
    """Play or pause; restart at the end."""
    player = player_of(session)
    if not player.playing and player.at >= player.recording.seconds:
        player.seek(0.0)
    player.playing = not player.playing


@action("replay-seek", repeats=True)
async def replay_seek(session: PageState, data: Data) -> None:
    """Go to a moment."""
    player_of(session).seek(float(data["value"]))
    session.show_moment()


@action("replay-speed", repeats=True)
async def replay_speed(session: PageState, data: Data) -> None:
    """Set the playback speed."""
    player_of(session).speed = float(data["value"])


@action("replay-close")
async def replay_close(session: PageState, data: Data) -> None:
    """Go back to the swarm."""
    session.player = None
    session.show_again()


async def meanwhile_busy(session: PageState, job: Callable[[], T]) -> T:
    """Run a slow function in a thread; the page is marked busy until the function ends."""
    session.busy += 1
    session.touch()
    try:
        return await asyncio.to_thread(job)
    finally:
        session.busy -= 1


def player_of(session: PageState) -> ReplayPlayer:
    """Return the player of the open recording.

    Raises:
        SwarmError: if none is.
    """
    if session.player is None:
        raise SwarmError("No recording is open.")
    return session.player
