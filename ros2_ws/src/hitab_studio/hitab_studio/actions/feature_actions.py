"""Actions of the dialog that exchanges the features of a training; the examples stay."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_core import START
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.example_effects import effect
from hitab_studio.pages.page import Page
from hitab_studio.pages.ui_remedies import error_text
from hitab_studio.pages.unavailable import training_of


@action("features-dialog")
async def features_dialog(page: Page, data: Data) -> None:
    """Open the dialog to choose features."""
    training = training_of(page)
    now, unseen = training.feature_labels, {"preview": None, "change": None, "problem": ""}
    about = {"name": training.name, "parameters": training.parameters}
    page.open_dialog("features", used=now, chosen=now, **about, **unseen)
    page.studio.link.probe(page.agent, on=True)


@action("features-preview", repeats=True)
async def features_preview(page: Page, data: Data) -> None:
    """Show a preview of the behavior learned from other features."""
    dialog = page.dialog
    if dialog.get("kind") != "features":
        return
    chosen = tuple(data["values"].get("features", []))
    dialog |= {"chosen": chosen, "preview": None, "change": None, "problem": ""}
    training = page.training
    if not chosen:
        dialog["problem"] = "Choose at least one feature for the decisions to depend on."
    elif training is not None and any(example.state == START for example in training.examples):
        try:
            preview = await page.ask_agent(
                lambda swarm, agent: swarm.agents.behavior.coroutine(
                    agent, with_features=list(chosen)
                )
            )
        except SwarmError as error:
            dialog["problem"] = error_text(error)
        else:
            dialog |= {"preview": preview, "change": effect(training, preview)}
