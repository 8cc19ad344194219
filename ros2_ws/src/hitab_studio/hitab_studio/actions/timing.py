"""For when commands count, and whose they are."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_client.demonstrating import put_earlier
from hitab_studio.actions.registry import Data, action
from hitab_studio.page import Page
from hitab_studio.people import checked
from hitab_studio.swarm_link import Connected


@action("name-set")
async def name_set(page: Page, data: Data) -> None:
    """Have the page be used by whom its person says; the browser keeps the name."""
    page.become(checked(str(data["values"].get("demonstrator", ""))))
    page.send({"t": "demonstrator", "name": page.demonstrator})
    page.close_dialog()


@action("earlier", repeats=True)
async def due_earlier(page: Page, data: Data) -> None:
    """Have the last command be due a little earlier than it is at present."""
    page.unseen.check(page.agent, "earlier")
    page.tell(
        await page.ask_agent(
            lambda swarm, agent: put_earlier.coroutine(swarm.agents, swarm.world, agent)
        )
    )


@action("retime", repeats=True)
async def retime(page: Page, data: Data) -> None:
    """Have a command be due at another time before it was given."""
    number, text = int(data["number"]), str(data["value"]).strip()
    try:
        ago = float(text)
    except ValueError:
        raise SwarmError(f'"{text}" is not a number of seconds, such as 0.3.') from None

    async def retimed(swarm: Connected, agent: str) -> float:
        await swarm.agents.retime.coroutine(agent, [number], ago)
        examples = (await swarm.agents.training.coroutine(agent)).examples
        return next((e.ago for e in examples if e.number == number), ago)  # that of a cycle

    page.tell(f"Example {number}: {await page.ask_agent(retimed):.2f} s ago")
