"""Actions for the times of commands and for the demonstrator's name."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_client.demonstrating import put_earlier
from hitab_core.operations import RetimeExamples
from hitab_studio.actions.registry import Data, action
from hitab_studio.page import Page
from hitab_studio.person_names import checked
from hitab_studio.swarm_link import Connected


@action("name-set")
async def name_set(page: Page, data: Data) -> None:
    """Set the demonstrator's name, which the browser keeps."""
    page.set_demonstrator(checked(str(data["values"].get("demonstrator", ""))))
    page.send({"t": "demonstrator", "name": page.demonstrator})
    page.close_dialog()


@action("earlier", repeats=True)
async def due_earlier(page: Page, data: Data) -> None:
    """Move the last command a little earlier, for a person who pressed late."""
    page.unseen.check(page.agent, "earlier")
    page.tell(
        await page.ask_agent(
            lambda swarm, agent: put_earlier.coroutine(swarm.agents, swarm.world, agent)
        )
    )


@action("retime", repeats=True)
async def retime(page: Page, data: Data) -> None:
    """Set the delay of a command: the time between its situation and the key press."""
    number, text = int(data["number"]), str(data["value"]).strip()
    try:
        ago = float(text)
    except ValueError:
        raise SwarmError(f'"{text}" is not a number of seconds, such as 0.3.') from None

    async def retimed(swarm: Connected, agent: str) -> float:
        await swarm.agents.do.coroutine(agent, RetimeExamples([number], ago))
        examples = (await swarm.agents.training.coroutine(agent)).examples
        return next((e.ago for e in examples if e.number == number), ago)  # rounded to a cycle

    page.tell(f"Example {number}: {await page.ask_agent(retimed):.2f} s ago")
