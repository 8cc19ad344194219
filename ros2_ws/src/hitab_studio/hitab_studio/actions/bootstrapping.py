"""Behavior bootstrapping: generations of what a team performs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hitab_client import SwarmError
from hitab_client.bootstrapping import Bootstrapping
from hitab_studio.actions.registry import Data, action
from hitab_studio.generations import Making
from hitab_studio.page import Page

MOST_EPISODES = 1000
LONGEST_NOTE = 200
"""Characters."""


@action("generations-dialog")
async def generations_dialog(page: Page, data: Data) -> None:
    """List the generations of a behavior, to make the next one or to go back."""
    agent, training = str(data.get("agent") or page.agent), page.training
    behavior = str(data.get("name") or (training.name if training is not None else ""))
    if not behavior:
        raise SwarmError("There is nothing to make a generation from yet: begin a training first.")
    page.close_dialog()
    page.dialog = {"kind": "generations", "agent": agent, "behavior": behavior}


@action("generation-next")
async def generation_next(page: Page, data: Data) -> None:
    """Make the next generation of what is being trained."""
    agent, note = page.dialog["agent"], str(data["values"].get("note", "")).strip()
    _begin(page, data, lambda steps: steps.next(agent, note[:LONGEST_NOTE]))


@action("generation-back")
async def generation_back(page: Page, data: Data) -> None:
    """Go back to a generation: the team performs it again, and the training goes on from it."""
    agent, behavior = page.dialog["agent"], page.dialog["behavior"]
    version, discard = int(data["number"]), data["values"].get("discard") == "on"
    _begin(page, data, lambda steps: steps.back(agent, behavior, version, discard))


@action("generation-stop")
async def generation_stop(page: Page, data: Data) -> None:
    """Stop what is under way at the next episode; the training goes on."""
    if (making := page.studio.generations.making) is not None:
        making.is_to_end = True


def _begin(page: Page, data: Data, step: Callable[[Bootstrapping], Any]) -> None:
    known, agent = page.studio.known, page.dialog["agent"]
    text = str(data["values"].get("episodes", "")).strip()
    if not text.isdigit() or int(text) > MOST_EPISODES:
        raise SwarmError(f"Give a number of episodes up to {MOST_EPISODES}; 0: no score.")
    if page.player is not None:
        raise SwarmError("This is a recording: close it first (Esc) to act on the swarm.")
    if not known.answers(agent):
        raise SwarmError(f"{agent} does not respond: wait until it answers again.")
    page.hold(agent)
    making = Making(agent, page.dialog["behavior"])
    page.studio.generations.begin(making, step, known, episodes=int(text), who=page.demonstrator)
