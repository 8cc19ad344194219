"""Saving, the library, and distributing behaviors."""

from __future__ import annotations

from typing import Any

from hitab_client import SwarmClient, SwarmError
from hitab_studio.actions.registry import Data, action
from hitab_studio.page_state import PageState, nothing_in_training
from hitab_studio.ui_remedies import answered, told


def _chosen(values: Any) -> dict[str, Any]:
    """Return how to save what was learned; values such as ``bind:ball`` are new bindings."""
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
async def save_dialog(session: PageState, data: Data) -> None:
    """Show what would be saved."""
    training = session.training
    if training is None:
        raise SwarmError(nothing_in_training(session))
    session.dialog = {
        "kind": "save",
        "agent": session.agent,
        "training": training,
        "preview": None,
        "problem": "",
    }
    await _preview(session, {})


@action("save-preview", repeats=True)
async def save_preview(session: PageState, data: Data) -> None:
    """Show the preview for other choices."""
    await _preview(session, data["values"])


async def _preview(session: PageState, values: Any) -> None:
    try:
        preview = await session.request(SwarmClient.behavior, trim=True, **_chosen(values))
    except SwarmError as error:
        session.dialog |= {"preview": None, "problem": told(error)}
    else:
        session.dialog |= {"preview": preview, "problem": ""}


@action("save")
async def save(session: PageState, data: Data) -> None:
    """Save what was trained, and show it in the library."""
    values = data["values"]
    training = session.dialog.get("training")
    # Without a name it is saved under the one that training began with.
    name = str(values.get("name", "")).strip() or (training.name if training else "")
    description = str(values.get("description", "")).strip()
    answer = await session.request(
        SwarmClient.save, name=name, description=description, **_chosen(values)
    )
    left_out = "; what nothing uses was left out" if answer.trimmed else ""
    session.dialog = {}
    session.tab = "library"
    session.behavior = name
    session.shared.link.want(session.agent, name)
    done = f"{answered(answer)}{left_out}".split("; ")
    session.tell("\n".join(done), "good" if len(done) == 1 else "note")


@action("library")
async def library(session: PageState, data: Data) -> None:
    """View a behavior of the library."""
    session.behavior = str(data["name"]) if session.behavior != data["name"] else ""
    session.compare = None
    session.shared.link.want(session.agent, str(data["name"]))


@action("versions")
async def versions(session: PageState, data: Data) -> None:
    """Show the differences between two versions."""
    name, agent = session.behavior, session.agent
    newer = int(data.get("newer") or data["values"]["newer"])
    older = int(data.get("older") or data["values"]["older"])
    compared = await session.ask(
        lambda swarm: swarm.agents.behavior.coroutine(
            agent, name, version=newer, compare_with=older
        )
    )
    session.compare = (f"{name}: version {older} → {newer}", compared)


@action("distribute")
async def distribute(session: PageState, data: Data) -> None:
    """Distribute a behavior and show each receiver's answer."""
    values = data["values"]
    behavior = session.dialog["name"]
    receivers = [str(r) for r in values.get("receivers", [])]
    if not receivers:
        raise SwarmError("Choose at least one receiver.")
    start = values.get("start") == "on"
    report = await session.request(
        SwarmClient.distribute, behavior, receivers=receivers, start=start
    )
    session.dialog["report"] = report
    session.tell(
        f"{behavior}: {len(report.accepted)} of {len(receivers)} have it",
        "bad" if report.missing else "good",
    )
