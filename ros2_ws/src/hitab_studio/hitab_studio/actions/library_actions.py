"""Actions that rename and delete behaviors of a library."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_client import SwarmError
from hitab_client.runs.run_folder import libraries_of
from hitab_client.terminal.cli_remedies import called
from hitab_core import BehaviorLibrary, load_domain
from hitab_studio.actions.recording_actions import meanwhile_busy
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page
from hitab_studio.swarm.swarm_link import Connected


@action("behavior-rename")
async def rename(page: Page, data: Data) -> None:
    """Rename a behavior, also in the behaviors that use it."""
    old, new = page.dialog["name"], str(data["values"].get("name", "")).strip()
    await change_library(
        page,
        lambda library: library.rename(old, new, with_users=True),
        f"{old} is called {new} now",
    )
    page.behavior = new


@action("behavior-delete")
async def delete(page: Page, data: Data) -> None:
    """Delete a behavior, even if others use it, of which the dialog warned."""
    name = page.dialog["name"]
    warned = bool(users_of(page, name))
    await change_library(
        page,
        lambda library: library.remove(name, anyway=warned),
        f"{name} is deleted; its versions are kept: `{called()} library restore {name}`",
    )
    page.behavior = ""


def users_of(page: Page, name: str) -> list[str]:
    """Return the names of the agent's behaviors that use a behavior."""
    return sorted(
        user.name
        for user in page.watched.behaviors.values()
        if user.name != name and name in user.behaviors_used
    )


async def change_library(page: Page, what: Callable[[BehaviorLibrary], Any], done: str) -> None:
    """Change the library of the agent, and reload it in all agents that use it.

    Raises:
        SwarmError: if the library's folder or domain is unknown here, or an agent does not reload
            the library.
        LibraryError: if the change is not possible.
    """
    agent, known = page.agent, page.studio.known
    used = libraries_of(Path(known.target.folder)) if known.target is not None else {}
    status = known.statuses.get(agent)
    if status is None or agent not in used or agent in known.groups:
        raise SwarmError(
            f"The library of {agent} cannot be changed here: use `{called()} library` in a "
            f"terminal, then `{called()} library reload {agent}`."
        )
    library = BehaviorLibrary(used[agent], load_domain(status.domain))

    page.take_agent()
    await meanwhile_busy(page, lambda: what(library))
    sharing = [name for name, folder in used.items() if folder == used[agent]]
    there = [name for name in sharing if known.answers(name)]

    async def read_again(swarm: Connected, _: str) -> list[str]:
        answers = [await it for it in swarm.agents.reloading(there)]
        return [f"{name} keeps its library: {why}" for name, why, did in answers if not did]

    refused = await page.ask_agent(read_again)
    page.close_dialog()
    page.tell(done)
    if refused:
        raise SwarmError("; ".join(refused))
