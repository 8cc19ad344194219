"""Actions for the emergency stop of all robots."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_core import some
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page

STOP_REASON = "emergency stop in the studio"
"""The reason of the stop, as shown to other people."""


async def stop_robots(page: Page) -> None:
    """Stop all robots at once, also while a recording is open.

    Pages request the stop over HTTP instead of as an action, so that it does not depend on their
    web socket.

    Raises:
        SwarmError: if the robots were not stopped.
    """
    try:
        there = page.studio.link.observer.stop_robots(True, page.demonstrator, STOP_REASON)
    except SwarmError as error:
        raise SwarmError(
            f"THE ROBOTS WERE NOT STOPPED: {error} Use the robots' own switches."
        ) from None
    heard = f": {some(there)}" if there else "; no robot is present, and new ones will obey"
    kind = "good" if there else "note"
    page.tell(f"Emergency stop: all have to stand still{heard}", kind)


@action("release-dialog")
async def release_dialog(page: Page, data: Data) -> None:
    """Open the dialog that confirms the release of the robots."""
    known = page.studio.known
    if known.is_stopped:
        page.close_dialog()
        page.dialog = {"kind": "release", "by": known.emergency.who}


@action("release-robots", urgent=True)
async def release_robots(page: Page, data: Data) -> None:
    """Release the emergency stop."""
    page.studio.link.observer.stop_robots(False, page.demonstrator, "")
    page.close_dialog()
    page.tell("Released: simulated worlds go on, and each robot waits to be re-armed")


@action("arm")
async def arm(page: Page, data: Data) -> None:
    """Re-arm the robot of the agent."""
    agent = page.agent
    await page.studio.link.observer.arm(agent)
    page.tell(f"{agent} may act")
