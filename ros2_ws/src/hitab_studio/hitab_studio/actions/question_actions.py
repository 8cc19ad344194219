"""Actions for an agent's questions and for unsure decisions."""

from __future__ import annotations

from hitab_client import SwarmClient, SwarmError
from hitab_studio.actions.registry import Data, action
from hitab_studio.page import Page


@action("answer")
async def answer(page: Page, data: Data) -> None:
    """Answer a question; without a choice, as proposed by the agent."""
    number, choice = int(data["number"]), str(data.get("choice", ""))
    answer = await page.request(SwarmClient.answer, number, choice)
    page.tell(f"{answer.message}; Undo brings it back")


@action("dismiss")
async def dismiss(page: Page, data: Data) -> None:
    """Dismiss a question, which is then not asked again."""
    number = int(data["number"])
    answer = await page.request(SwarmClient.answer, number, dismiss=True)
    page.tell(answer.message)


@action("caution")
async def caution(page: Page, data: Data) -> None:
    """Set the agent's reaction to unsure decisions."""
    values = data["values"]
    try:
        distance = float(values.get("distance") or 0.0)
    except ValueError:
        raise SwarmError("Give a number of usual distances, such as 3.") from None
    when_unsure = str(values["when_unsure"])
    answer = await page.request(SwarmClient.set_caution, when_unsure, distance=distance)
    page.close_dialog()
    page.tell(answer.message)
