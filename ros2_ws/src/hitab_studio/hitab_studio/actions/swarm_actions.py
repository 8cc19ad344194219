"""Actions that start, choose and stop swarms."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page


@action("swarm-start")
async def swarm_start(page: Page, data: Data) -> None:
    """Start a swarm."""
    name = str(data["values"].get("swarm", ""))
    launcher = page.studio.launcher
    if name not in launcher.startable:
        raise SwarmError(f'"{name}" is not a swarm that can be started here.')
    launcher.run("up", name)


@action("swarm-about", repeats=True)
async def swarm_about(page: Page, data: Data) -> None:
    """Show the description of a swarm that may be started."""
    page.to_start = str(data["value"])


@action("swarm-choose")
async def swarm_choose(page: Page, data: Data) -> None:
    """Switch all pages to another running swarm."""
    target = page.studio.known.target
    chosen = (
        next((c for c in target.choices if c.folder == data["name"]), None) if target else None
    )
    if chosen is None:
        raise SwarmError("That swarm is not up any more.")
    if why := page.studio.why_busy:
        raise SwarmError(why)
    page.studio.link.choose(chosen.folder)
    for other in list(page.studio.pages.values()):
        if other is not page:
            other.tell(f"{page.name} has chosen {chosen.swarm}", "note")


@action("swarm-stop")
async def swarm_stop(page: Page, data: Data) -> None:
    """Stop the swarm."""
    target = page.studio.known.target
    if target is None or not target.folder:
        raise SwarmError("No swarm that this page can stop is up.")
    page.close_dialog()
    page.studio.launcher.run("down", target.swarm)


@action("launch-dismiss")
async def launch_dismiss(page: Page, data: Data) -> None:
    """Close the output of a failed start or stop."""
    page.studio.launcher.dismiss()
