"""Actions that record runs and replay recordings."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

from hitab_client import SwarmError
from hitab_client.recording import recordings
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import RECORDING, Page
from hitab_studio.swarm.replay import Recording, ReplayPlayer

T = TypeVar("T")


@action("record")
async def record(page: Page, data: Data) -> None:
    """Start or stop recording the run."""
    if page.player is not None:
        raise SwarmError(RECORDING)
    known, observer = page.studio.known, page.studio.link.observer
    if known.recording:
        page.tell(f"Recorded to {observer.stop_recording()}")
    else:
        path = recordings.new_recording(known.target.swarm if known.target else "")
        observer.start_recording(str(path), page.id)
    page.tab = "record"


@action("replay")
async def replay(page: Page, data: Data) -> None:
    """Open a recording."""
    path = recordings.recording(str(data["name"]))
    page.player = ReplayPlayer(await meanwhile_busy(page, lambda: Recording(path)))
    if page.player.recording.missing:
        page.tell(page.player.recording.missing)
    page.show_again()


@action("recording-rename")
async def rename(page: Page, data: Data) -> None:
    """Rename a recording."""
    name = page.dialog["name"]
    _not_being_recorded(page, name)
    path = recordings.rename(name, str(data["values"].get("name", "")))
    page.close_dialog()
    page.tell(f"{name} is called {path.name} now")


@action("recording-delete")
async def delete(page: Page, data: Data) -> None:
    """Delete a recording."""
    name = page.dialog["name"]
    _not_being_recorded(page, name)
    recordings.delete(name)
    page.close_dialog()
    page.tell(f"{name} is deleted")


def _not_being_recorded(page: Page, name: str) -> None:
    if page.studio.known.recording.endswith(f"/{name}"):
        raise SwarmError(f"{name} is being recorded: stop that first.")


@action("replay-play")
async def replay_play(page: Page, data: Data) -> None:
    """Play or pause the recording; at its end, play from the beginning."""
    player = player_of(page)
    if not player.playing and player.at >= player.recording.seconds:
        player.seek(0.0)
    player.playing = not player.playing


@action("replay-seek", repeats=True)
async def replay_seek(page: Page, data: Data) -> None:
    """Go to a moment of the recording."""
    player_of(page).seek(float(data["value"]))
    page.show_moment()


@action("replay-speed", repeats=True)
async def replay_speed(page: Page, data: Data) -> None:
    """Set the playback speed."""
    player_of(page).speed = float(data["value"])


@action("replay-close")
async def replay_close(page: Page, data: Data) -> None:
    """Close the recording, and show the swarm."""
    page.player = None
    page.show_again()


async def meanwhile_busy(page: Page, job: Callable[[], T]) -> T:
    """Run a slow function in a thread; the page is marked busy until the function ends."""
    page.busy += 1
    page.touch()
    try:
        return await asyncio.to_thread(job)
    finally:
        page.busy -= 1


def player_of(page: Page) -> ReplayPlayer:
    """Return the player of the open recording.

    Raises:
        SwarmError: if no recording is open.
    """
    if page.player is None:
        raise SwarmError("No recording is open.")
    return page.player
