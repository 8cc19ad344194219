"""Actions that go to what deserves a look."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_client.attention import Item, others_alike
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page
from hitab_studio.pages.ui_remedies import in_studio

WAYS_MAX = 3
"""Maximum number of remedies in a message."""


@action("item-next", repeats=True)
async def item_next(page: Page, data: Data) -> None:
    """Go to the item after the one that was looked at last; the first one comes after the last."""
    items = page.studio.known.attention
    if not items:
        raise SwarmError("Nothing deserves a look.")
    keys = [item.key for item in items]
    last = keys.index(page.item.key) if page.item and page.item.key in keys else -1
    _go_to(page, items[(last + 1) % len(items)])


@action("item", repeats=True)
async def item(page: Page, data: Data) -> None:
    """Go to an item in the list."""
    number = int(data["number"])
    items = page.studio.known.attention
    if number < len(items):
        _go_to(page, items[number])


def _go_to(page: Page, chosen: Item) -> None:
    """View the first agent of an item in the middle of the field, and tell the ways out."""
    page.item = chosen
    name = chosen.names[0]
    if name in page.agents:
        page.choose([name])
        page.look_at(name)
        page.send({"t": "center", "name": name})
    ways = map(in_studio, chosen.remedies[:WAYS_MAX])
    page.tell("\n".join(filter(None, (str(chosen), chosen.why, *ways))), "note")


def offer_to_others(page: Page, behavior: str) -> None:
    """Ask whether a saved correction should be given to the others in the same situation."""
    if page.item is None or page.agent not in page.item.names:
        return
    others = others_alike(page.studio.known.attention, page.item, page.agent)
    others = [name for name in others if page.studio.known.answers(name)]
    if others:
        page.open_dialog("distribute", name=behavior, alike=others, what=page.item.what)
