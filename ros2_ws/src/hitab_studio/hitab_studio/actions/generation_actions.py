"""Actions for behavior bootstrapping, with generations of a team's behavior.

Making a generation takes minutes, since the team plays episodes for a score. Meanwhile other
requests to the swarm are refused, all pages show the progress, and any of them may stop it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hitab_client import SwarmError
from hitab_client.bootstrapping import Bootstrapping, generations_folder, read_generations
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page
from hitab_studio.pages.page_parts import Making
from hitab_studio.swarm.swarm_link import Connected

EPISODES_MAX = 1000
NOTE_LENGTH_MAX = 200
"""Maximum length of a note, characters."""


@action("generations-dialog")
async def generations_dialog(page: Page, data: Data) -> None:
    """Open the dialog with the generations of a behavior."""
    page.look_at(str(data.get("agent") or page.agent))
    training = page.training
    behavior = str(data.get("name") or (training.name if training is not None else ""))
    if not behavior:
        raise SwarmError("There is nothing to make a generation from yet: begin a training first.")
    page.close_dialog()
    _show(page, page.agent, behavior)


@action("generation-next", urgent=True)
async def generation_next(page: Page, data: Data) -> None:
    """Make the next generation of the trained behavior."""
    agent, note = page.dialog["agent"], str(data["values"].get("note", "")).strip()
    await _make(page, data, lambda steps: steps.next(agent, note[:NOTE_LENGTH_MAX]))


@action("generation-back", urgent=True)
async def generation_back(page: Page, data: Data) -> None:
    """Go back to a generation: the team performs it, and the training continues from it."""
    agent, behavior = page.dialog["agent"], page.dialog["behavior"]
    version, discard = int(data["number"]), data["values"].get("discard") == "on"
    await _make(page, data, lambda steps: steps.back(agent, behavior, version, discard))


@action("generation-stop", urgent=True)
async def generation_stop(page: Page, data: Data) -> None:
    """Stop making a generation at the next episode; the training continues."""
    if page.studio.making is not None:
        page.studio.making.is_to_end = True


def _show(page: Page, agent: str, behavior: str) -> None:
    target = page.studio.known.target
    folder = generations_folder(target.folder if target is not None else None, agent)
    known = read_generations(folder, behavior)
    about = {"kind": "generations", "agent": agent, "behavior": behavior, "generations": known}
    page.dialog |= about


async def _make(page: Page, data: Data, step: Callable[[Bootstrapping], Any]) -> None:
    studio, behavior = page.studio, page.dialog["behavior"]
    known, target = studio.known, studio.known.target
    text = str(data["values"].get("episodes", "")).strip()
    if not text.isdigit() or int(text) > EPISODES_MAX:
        raise SwarmError(f"Give a number of episodes up to {EPISODES_MAX}; 0: no score.")
    page.look_at(page.dialog["agent"])
    making = studio.making = Making(page.take_agent(), behavior)

    def job(swarm: Connected) -> None:
        def progress(done: int, total: int, doing: str) -> None:
            if making.is_to_end:
                raise SwarmError("It was stopped.")
            making.doing = f"{doing}, {done} of {total}"
            studio.touch()

        step(
            Bootstrapping(
                swarm.agents,
                swarm.world if known.world is not None else None,
                target.folder if target is not None else None,
                episodes=int(text),
                who=page.demonstrator,
                say=making.said.append,
                progress=progress,
            )
        )
        making.said.append(f"Done: {making.agent} is being trained further.")

    try:
        # Unlike `SwarmLink.ask`, `do` is not ended by a short silence of the agent.
        await studio.link.do(job, making.agent)
    finally:
        making.doing = ""
        studio.touch()
        for other in studio.pages.values():
            if other.dialog.get("kind") == "generations":
                _show(other, other.dialog["agent"], other.dialog["behavior"])
