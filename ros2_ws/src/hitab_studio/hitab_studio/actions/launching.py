"""Starting and stopping swarms."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_studio.actions.registry import Data, action
from hitab_studio.page_state import PageState


@action("swarm-start")
async def swarm_start(session: PageState, data: Data) -> None:
    """Start a swarm."""
    name = str(data["values"].get("swarm", ""))
    launcher = session.shared.launcher
    if name not in launcher.startable:
        raise SwarmError(f'"{name}" is not a swarm that can be started here.')
    launcher.run("up", name)


@action("swarm-about", repeats=True)
async def swarm_about(session: PageState, data: Data) -> None:
    """Say what the swarm is that is chosen to be started."""
    session.to_start = str(data["value"])


@action("swarm-choose")
async def swarm_choose(session: PageState, data: Data) -> None:
    """Show another swarm that is up, on all pages."""
    target = session.shared.store.known.target
    chosen = (
        next((c for c in target.choices if c.folder == data["name"]), None) if target else None
    )
    if chosen is None:
        raise SwarmError("That swarm is not up any more.")
    if why := session.shared.why_busy:
        raise SwarmError(why)
    session.shared.link.choose(chosen.folder)
    for other in list(session.shared.sessions.values()):
        if other is not session:
            other.tell(f"{session.name} has chosen {chosen.swarm}", "note")


@action("swarm-stop")
async def swarm_stop(session: PageState, data: Data) -> None:
    """Stop the swarm."""
    target = session.shared.store.known.target
    if target is None or not target.folder:
        raise SwarmError("No swarm is up that could be stopped.")
    session.close_dialog()
    session.shared.launcher.run("down", target.swarm)


@action("launch-dismiss")
async def launch_dismiss(session: PageState, data: Data) -> None:
    """Close what a failed start or stop has said."""
    session.shared.launcher.dismiss()
