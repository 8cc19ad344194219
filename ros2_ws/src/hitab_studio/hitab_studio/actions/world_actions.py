"""Actions that run the world and place things."""

from __future__ import annotations

from typing import Any

from hitab_msgs.msg import WorldState

from hitab_client import SwarmError, WorldClient
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page

UNDO_MAX = 100
PAUSED = WorldState.PAUSED


@action("pause")
async def pause(page: Page, data: Data) -> None:
    """Pause or resume the world."""
    world = page.studio.known.world
    wanted = "resume" if world is not None and world.mode == PAUSED else "pause"
    await page.ask_world(lambda world: world.control.coroutine(wanted))


@action("step", repeats=True)
async def step(page: Page, data: Data) -> None:
    """Run the world for some cycles, then pause."""
    cycles = int(data.get("cycles", 1))
    await page.ask_world(lambda world: world.step.coroutine(cycles, 5.0))


@action("reset")
async def reset(page: Page, data: Data) -> None:
    """Start a new episode."""
    _remember(page)
    await page.ask_world(lambda world: world.control.coroutine("reset"))


@action("pace")
async def pace(page: Page, data: Data) -> None:
    """Set the speed of the world: a factor of real time, or lockstep."""
    lockstep = data["value"] == "lockstep"
    pace, factor = ("lockstep", 0.0) if lockstep else ("realtime", float(data["value"]))
    await page.ask_world(lambda world: world.control.coroutine("pace", pace=pace, factor=factor))


def _remember(page: Page) -> None:
    """Remember the positions of all things, for undo."""
    studio = page.studio
    if studio.known.scene is not None:
        studio.placements.append(studio.known.scene.everything())
        del studio.placements[:-UNDO_MAX]


@action("place", repeats=True)
async def place(page: Page, data: Data) -> None:
    """Place dragged things."""
    if page.time.past is not None:
        page.show_again()
        raise SwarmError(
            "This moment is past, so nothing can be moved: press Esc to return to now, or Enter "
            "to continue from here."
        )
    things = {
        str(name): {key: float(value) for key, value in where.items()}
        for name, where in data["things"].items()
    }
    _remember(page)
    try:
        await page.ask_world(lambda world: _placed(world, things))
    except SwarmError:
        page.studio.placements.pop()
        page.show_again()
        raise


async def _placed(world: WorldClient, things: Any) -> None:
    answer = await world.place.coroutine(things)
    if world.is_paused:
        # The agents must perceive the placement before the next command.
        await world.shown.coroutine(answer, 3.0)


async def paused(world: WorldClient) -> bool:
    """Pause the world; return whether the world was running."""
    if (await world.wait.coroutine()).mode == PAUSED:
        return False
    await world.control.coroutine("pause")
    return True


@action("unplace", repeats=True)
async def unplace(page: Page, data: Data) -> None:
    """Undo the last placement."""
    placements = page.studio.placements
    if not placements:
        raise SwarmError("There is no placement to undo.")
    things = placements.pop()
    await page.ask_world(lambda world: _placed(world, things))
    page.tell("The placement is undone")


@action("snapshots")
async def snapshots(page: Page, data: Data) -> None:
    """Show the snapshots of the world."""
    await _snapshot(page, "list")
    page.dialog = {"kind": "snapshots"}


@action("snapshot-save")
async def snapshot_save(page: Page, data: Data) -> None:
    """Save the world's state under a name."""
    name = str(data["values"].get("name", "")).strip()
    if not name:
        raise SwarmError("Give the snapshot a name.")
    await _snapshot(page, "save", name)
    page.tell(f'kept as "{name}"')


@action("snapshot-restore")
async def snapshot_restore(page: Page, data: Data) -> None:
    """Restore a snapshot."""
    name = str(data["name"])
    _remember(page)
    await _snapshot(page, "restore", name)
    page.dialog = {}
    page.tell(f'"{name}" is back')


@action("snapshot-delete")
async def snapshot_delete(page: Page, data: Data) -> None:
    """Delete a snapshot."""
    await _snapshot(page, "delete", str(data["name"]))


async def _snapshot(page: Page, what: str, name: str = "") -> None:
    answer = await page.ask_world(lambda world: world.snapshot.coroutine(what, name))
    page.studio.snapshots = tuple(answer.names)


async def go_there(page: Page, things: Any) -> None:
    """Pause the world, and place all things."""
    _remember(page)

    async def moved(world: WorldClient) -> None:
        await paused(world)
        await _placed(world, things)

    await page.ask_world(moved)
