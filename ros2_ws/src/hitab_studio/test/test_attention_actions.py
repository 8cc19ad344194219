"""One key goes to the next thing that deserves a look, and corrections are offered to others."""

from __future__ import annotations

import asyncio
import json
from dataclasses import replace
from typing import Any

from hitab_msgs.msg import AgentStatus

from hitab_client.attention import Concern, Item, Kind, ranked
from hitab_studio.actions.attention_actions import offer_to_others
from hitab_studio.pages.page import Page
from hitab_studio.pages.page_view import perform
from hitab_studio.studio import Studio
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState
from hitab_studio.views import render

ANTS = ("ant_1", "ant_2", "ant_3", "ant_4")


def items(*concerns: Concern) -> tuple[Item, ...]:
    return tuple(ranked(concerns, {}))


STUCK = [Concern(Kind.STUCK, name, "stuck in Search", teaches="Forage") for name in ANTS[1:]]
SILENT = Concern(Kind.SILENT, "host_1", "gives no signs of life")
ITEMS = items(SILENT, *STUCK, Concern(Kind.LIBRARY, "ant_1", "has other behaviors than most"))


def page_with(*requests: dict[str, Any], found: tuple[Item, ...] = ITEMS) -> Page:
    """Return the page of a swarm with items, after some requests."""

    async def made() -> Page:
        studio = Studio(lambda: SwarmTarget(0))
        statuses = {name: AgentStatus(agent=name) for name in ANTS}
        studio.known = replace(SwarmState(), statuses=statuses, attention=found)
        page = studio.open()
        for request in requests:
            await perform(page, request)
        return page

    return asyncio.run(made())


def centered(page: Page) -> list[str]:
    sent = map(json.loads, page.outgoing)
    return [message["name"] for message in sent if message["t"] == "center"]


def test_the_key_goes_from_item_to_item_and_begins_again_after_the_last():
    next_ = {"do": "item-next"}
    page = page_with(next_, next_)
    assert (page.agent, page.chosen, centered(page)) == ("ant_2", ["ant_2"], ["ant_2"])
    assert page_with(*[next_] * 3).agent == "ant_1"
    assert page_with(*[next_] * 5).agent == "ant_2"


def test_of_a_host_only_the_words_are_shown():
    page = page_with({"do": "item-next"})
    assert (page.agent, centered(page)) == ("", [])
    assert "host_1: gives no signs of life" in page.messages.shown[-1].text


def test_the_list_in_the_tab_goes_to_the_same_places():
    page = page_with({"do": "tab", "name": "swarm"}, {"do": "item", "number": "2"})
    assert page.agent == "ant_1"
    assert 'data-test="item-2"' in render("side", page)
    assert "3 items deserve a look" in render("agents", page)


def test_without_items_there_is_nothing_to_go_to():
    page = page_with({"do": "item-next"}, found=())
    assert "Nothing deserves a look." in page.messages.shown[-1].text
    assert "deserve a look" not in render("agents", page)


def test_what_was_saved_for_one_is_offered_to_the_others_in_its_situation():
    page = page_with({"do": "item", "number": "1"})
    assert page.agent == "ant_2"
    offer_to_others(page, "Forage")
    asked = render("dialog", page)
    assert "2 other agents are in the same situation (stuck in Search)" in asked
    assert 'value="ant_3"' in asked
    assert 'value="ant_1"' not in asked


def test_a_correction_of_another_agent_is_offered_to_nobody():
    page = page_with({"do": "item", "number": "1"}, {"do": "agent", "name": "ant_1"})
    offer_to_others(page, "Forage")
    assert page.dialog == {}
