"""Actions that save, view, compare and distribute behaviors."""

from __future__ import annotations

from dataclasses import replace

from hitab_client import SwarmError
from hitab_core.operations import Distribute, SaveBehavior
from hitab_ros.messages.conversions import pairs_message
from hitab_studio.actions.attention_actions import offer_to_others
from hitab_studio.actions.operation_actions import carry_out, operation_of
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page
from hitab_studio.pages.ui_remedies import error_text
from hitab_studio.pages.unavailable import training_of


@action("save-dialog")
async def save_dialog(page: Page, data: Data) -> None:
    """Open the dialog to save the trained behavior, with a preview."""
    page.open_dialog("save", training=training_of(page), preview=None, problem="")
    await save_preview(page, {"values": {}})


@action("save-preview", repeats=True)
async def save_preview(page: Page, data: Data) -> None:
    """Update the preview for other options."""
    save = operation_of(SaveBehavior, page, data)
    bindings = pairs_message(save.bindings.items())
    try:
        preview = await page.ask_agent(
            lambda swarm, agent: swarm.agents.behavior.coroutine(
                agent, trim=True, bindings=bindings, keep_unused=save.keep_unused
            )
        )
    except SwarmError as error:
        page.dialog |= {"preview": None, "problem": error_text(error)}
    else:
        page.dialog |= {"preview": preview, "problem": ""}


@action("save_behavior")
async def save(page: Page, data: Data) -> None:
    """Save the trained behavior, and show it in the library."""
    operation = operation_of(SaveBehavior, page, data)
    name = operation.automaton or training_of(page).name
    await carry_out(page, operation)
    page.tab, page.behavior = "library", name
    page.studio.link.want(page.agent, name)
    offer_to_others(page, name)


@action("library")
async def library(page: Page, data: Data) -> None:
    """View a behavior of the library."""
    page.behavior = str(data["name"]) if page.behavior != data["name"] else ""
    page.compare = None
    page.studio.link.want(page.agent, str(data["name"]))


@action("versions")
async def versions(page: Page, data: Data) -> None:
    """Show the differences between two versions."""
    name, agent = page.behavior, page.agent
    newer = int(data.get("newer") or data["values"]["newer"])
    older = int(data.get("older") or data["values"]["older"])
    compared = await page.ask(
        lambda swarm: swarm.agents.behavior.coroutine(
            agent, name, version=newer, compare_with=older
        )
    )
    page.compare = (f"{name}: version {older} → {newer}", compared)


@action("distribute")
async def distribute(page: Page, data: Data) -> None:
    """Distribute a behavior and show each receiver's answer."""
    by, behavior = page.demonstrator, page.dialog["name"]
    sent = replace(operation_of(Distribute, page, data, behavior=behavior), by=by)
    if not sent.receivers:
        raise SwarmError("Choose at least one receiver.")
    report = await page.ask_agent(
        lambda swarm, agent: swarm.agents.distribute.coroutine(agent, sent)
    )
    page.dialog["report"] = report
    page.tell(
        f"{behavior}: {len(report.accepted)} of {len(sent.receivers)} have it",
        "bad" if report.missing else "good",
    )
