"""Actions that label an agent's moments in a recording, correct labels, and train from them."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_client.recording import driving_of
from hitab_core import named_domain
from hitab_core.labeling import Span, Strip
from hitab_studio.actions.library_actions import change_library
from hitab_studio.actions.recording_actions import meanwhile_busy, player_of
from hitab_studio.actions.registry import Data, action
from hitab_studio.pages.page import Page
from hitab_studio.swarm.replay import Labels, ReplayPlayer


@action("label-dialog")
async def ask(page: Page, data: Data) -> None:
    """Open the dialog to choose the features and behaviors for labels."""
    if page.status is None:
        raise SwarmError("Choose an agent of the recording first.")
    domain = named_domain(page.status.domain)
    page.open_dialog("label", domain=domain)


@action("label")
async def label(page: Page, data: Data) -> None:
    """Label each moment of the agent with a behavior."""
    player, dialog, chosen = player_of(page), page.dialog, data["values"]
    features, behaviors = chosen.get("features", []), chosen.get("states", [])

    def made() -> Labels:
        driven = driving_of(player.recording.path, dialog["agent"])
        strip = Strip(driven.moments, dialog["domain"], driven.agent, behaviors, features)
        return Labels(strip, driven.start - player.recording.start)

    player.labels = await meanwhile_busy(page, made)
    page.close_dialog()


@action("label-span", repeats=True)
async def look_at_span(page: Page, data: Data) -> None:
    """Select a span, and go to its beginning."""
    player = player_of(page)
    labels, span = _labels(player), _span(player, int(data["number"]))
    labels.chosen = int(data["number"])
    player.playing = False
    player.seek(span.begin + labels.offset)
    page.show_moment()


@action("label-was")
async def correct(page: Page, data: Data) -> None:
    """Correct the label of a span, and label the other moments again."""
    player = player_of(page)
    labels, span = _labels(player), _span(player, int(data["number"]))

    def corrected() -> None:
        before = dict(labels.strip.known)
        labels.strip.correct(span.begin, span.end, str(data["value"]))
        try:
            labels.strip.label()
        except Exception:
            labels.strip.known = before
            raise

    await meanwhile_busy(page, corrected)
    spans = enumerate(labels.strip.spans)
    labels.chosen = next((i for i, s in spans if s.begin <= span.begin < s.end), -1)


@action("label-train")
async def train(page: Page, data: Data) -> None:
    """Train a behavior from the labels, and save it in the library of the agent in the swarm."""
    player, name = player_of(page), str(data["values"].get("name", "")).strip()
    strip, source = _labels(player).strip, player.recording.path.name
    page.look_at(strip.agent)
    page.player = None  # the library is changed in the swarm, not in the recording
    try:
        await change_library(
            page, lambda library: strip.train(name, library, source), f"{name} is trained"
        )
    except Exception:
        page.player = player
        raise
    page.tab, page.behavior = "library", name
    page.show_again()


def _labels(player: ReplayPlayer) -> Labels:
    if player.labels is None:
        raise SwarmError("Nothing is labeled yet.")
    return player.labels


def _span(player: ReplayPlayer, number: int) -> Span:
    spans = _labels(player).strip.spans
    if not 0 <= number < len(spans):
        raise SwarmError("The strip has changed meanwhile: choose again.")
    return spans[number]
