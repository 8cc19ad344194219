"""Actions for the time: look back, continue from there, the pace of teaching, breakpoints."""

from __future__ import annotations

from typing import Any

from hitab_msgs.srv import Control

from hitab_client import SwarmError, WorldClient
from hitab_core.operations import SetBreakpoints
from hitab_studio.actions.operation_actions import carry_out, operation_of
from hitab_studio.actions.registry import Data, action
from hitab_studio.actions.world_actions import paused
from hitab_studio.pages import unavailable
from hitab_studio.pages.looking_back import look_back, to_present
from hitab_studio.pages.page import Page


@action("past", repeats=True)
async def past(page: Page, data: Data) -> None:
    """Show a moment of the last minute, or one some cycles or seconds beside the shown one."""
    minute, shown = page.studio.link.minute, page.time.past
    step, seconds = int(data.get("step") or 0), float(data.get("seconds") or 0.0)
    if (player := page.player) is not None:
        player.playing = False
        at = float(data.get("to", player.at)) + seconds
        player.seek(player.recording.beside(at, step) if step else at)
        page.show_moment()
        return
    here = float(data["to"]) if "to" in data else shown.at if shown is not None else minute.now
    look_back(page, here + seconds * minute.rate, step)


@action("present", repeats=True)
async def present(page: Page, data: Data) -> None:
    """Show the present."""
    to_present(page)


@action("continue-from")
async def continue_from(page: Page, data: Data) -> None:
    """Put the world back to the shown moment, where it pauses."""
    if why := unavailable.going_back(page):
        raise SwarmError(why)
    assert page.time.past is not None
    await _control(page, Control.Request.BACK, to=int(page.time.past.at))
    page.time.frozen = None
    to_present(page)
    page.tell("The world is back there, and paused; Space lets it run")


@action("teaching")
async def teaching(page: Page, data: Data) -> None:
    """Set the further factor of the world's pace while an agent is taught."""
    await _control(page, Control.Request.TEACHING, factor=float(data["value"]))


async def _control(page: Page, what: str, **fields: Any) -> None:
    await page.ask_world(lambda world: world.control.coroutine(what, **fields))


# -- freezing at a key ----------------------------------------------------------------------------


@action("freezes")
async def freezes(page: Page, data: Data) -> None:
    """Choose whether the first key of a behavior pauses the world; the browser keeps it."""
    page.time.freezes = bool(data["value"])
    page.send({"t": "remember", "name": "freezes", "value": "1" if page.time.freezes else ""})


async def frozen_now(page: Page) -> bool:
    """Pause the world if this is a first key; return whether it was."""
    time, world = page.time, page.studio.known.world
    if not time.freezes or not page.is_training or time.past is not None or world is None:
        return False

    async def freeze(world: WorldClient) -> int | None:
        return world.status.cycle if await paused(world) and world.status else None

    if (cycle := await page.ask_world(freeze)) is not None:
        time.frozen = cycle
    return cycle is not None


async def thaw(page: Page) -> None:
    """Resume the world if it still rests where a first key has paused it."""
    cycle, page.time.frozen = page.time.frozen, None

    async def resume(world: WorldClient) -> None:
        if world.is_paused and world.status and world.status.cycle == cycle:
            await world.control.coroutine("resume")

    if cycle is not None:
        await page.ask_world(resume)


# -- breakpoints ----------------------------------------------------------------------------------


@action("breakpoint")
async def breakpoint_(page: Page, data: Data) -> None:
    """Set a breakpoint of the agent, or clear it."""
    place = str(data["place"])
    there = list(page.status.breakpoints) if page.status is not None else []
    wanted = [b for b in there if b != place] if place in there else [*there, place]
    await carry_out(page, operation_of(SetBreakpoints, page, data, breakpoints=wanted))
