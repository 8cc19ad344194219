"""Actions that save, view, compare and distribute behaviors."""

from __future__ import annotations

from typing import Any

from hitab_client import SwarmClient, SwarmError
from hitab_studio.actions.registry import Data, action
from hitab_studio.page import Page
from hitab_studio.ui_remedies import answer_text, error_text
from hitab_studio.unavailable import training_of


def _chosen(values: Any) -> dict[str, Any]:
    """Return the options for saving; values such as ``bind:ball`` turn targets to parameters."""
    bound = {
        key.removeprefix("bind:"): str(value).strip()
        for key, value in values.items()
        if key.startswith("bind:") and str(value).strip()
    }
    return {
        "bind_from": list(bound),
        "bind_to": list(bound.values()),
        "keep_unused": values.get("keep") == "on",
    }


@action("save-dialog")
async def save_dialog(page: Page, data: Data) -> None:
    """Open the dialog to save the trained behavior, with a preview."""
    page.open_dialog("save", training=training_of(page), preview=None, problem="")
    await save_preview(page, {"values": {}})


@action("save-preview", repeats=True)
async def save_preview(page: Page, data: Data) -> None:
    """Update the preview for other options."""
    try:
        preview = await page.request(SwarmClient.behavior, trim=True, **_chosen(data["values"]))
    except SwarmError as error:
        page.dialog |= {"preview": None, "problem": error_text(error)}
    else:
        page.dialog |= {"preview": preview, "problem": ""}


@action("save")
async def save(page: Page, data: Data) -> None:
    """Save the trained behavior, and show it in the library."""
    values = data["values"]
    training = page.dialog.get("training")
    # The default is the name with which the training began.
    name = str(values.get("name", "")).strip() or (training.name if training else "")
    description = str(values.get("description", "")).strip()
    answer = await page.request(
        SwarmClient.save, name=name, description=description, **_chosen(values)
    )
    left_out = "; unused features and behaviors were left out" if answer.trimmed else ""
    page.dialog = {}
    page.tab = "library"
    page.behavior = name
    page.studio.link.want(page.agent, name)
    done = f"{answer_text(answer)}{left_out}".split("; ")
    page.tell("\n".join(done), "good" if len(done) == 1 else "note")


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
    values = data["values"]
    behavior = page.dialog["name"]
    receivers = [str(r) for r in values.get("receivers", [])]
    if not receivers:
        raise SwarmError("Choose at least one receiver.")
    start = values.get("start") == "on"
    report = await page.request(SwarmClient.distribute, behavior, receivers=receivers, start=start)
    page.dialog["report"] = report
    page.tell(
        f"{behavior}: {len(report.accepted)} of {len(receivers)} have it",
        "bad" if report.missing else "good",
    )
