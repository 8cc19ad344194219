"""Answers an agent's questions about its examples, and sets its behavior when unsure."""

from __future__ import annotations

from hitab_client import SwarmClient, SwarmError
from hitab_studio.actions.registry import Data, action
from hitab_studio.page import Page


@action("answer")
async def answer(page: Page, data: Data) -> None:
    """Answer a question; without a choice, as the agent proposes."""
    number, choice = int(data["number"]), str(data.get("choice", ""))
    answer = await page.request(SwarmClient.answer, number, choice)
    page.tell(f"{answer.message}; Undo brings it back")


@action("dismiss")
async def dismiss(page: Page, data: Data) -> None:
    """Have a question not be asked again."""
    number = int(data["number"])
    answer = await page.request(SwarmClient.answer, number, dismiss=True)
    page.tell(answer.message)


@action("caution")
async def caution(page: Page, data: Data) -> None:
    """Say what the agent does when it is unsure."""
    values = data["values"]
    try:
        distance = float(values.get("distance") or 0.0)
    except ValueError:
        raise SwarmError("Give a number of usual distances, such as 3.") from None
    when_unsure = str(values["when_unsure"])
    answer = await page.request(SwarmClient.set_caution, when_unsure, distance=distance)
    page.close_dialog()
    page.tell(answer.message)
