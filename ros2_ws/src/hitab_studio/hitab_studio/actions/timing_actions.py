"""Actions for the times of commands and for the demonstrator's name."""

from __future__ import annotations

from hitab_client.demonstrating import put_earlier
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page
from hitab_studio.pages.person_names import checked


@action("name-set")
async def name_set(page: Page, data: Data) -> None:
    """Set the demonstrator's name, which the browser keeps."""
    page.set_demonstrator(checked(str(data["values"].get("demonstrator", ""))))
    page.send({"t": "remember", "name": "demonstrator", "value": page.demonstrator})
    page.close_dialog()


@action("earlier", repeats=True)
async def due_earlier(page: Page, data: Data) -> None:
    """Move the last command a little earlier, for a person who pressed late."""
    page.tell(
        await page.ask_agent(
            lambda swarm, agent: put_earlier.coroutine(swarm.agents, swarm.world, agent)
        )
    )
