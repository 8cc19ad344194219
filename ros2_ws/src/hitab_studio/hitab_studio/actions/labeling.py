"""Labeling what an agent did in a recording, correcting that, and training from it."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_client.recording import driving_of
from hitab_core import named_domain
from hitab_core.labeling import Span, Strip
from hitab_studio.actions.library_changes import change_library
from hitab_studio.actions.recording import meanwhile_busy, player_of
from hitab_studio.actions.registry import Data, action
from hitab_studio.page_state import PageState
from hitab_studio.replay import Labels, ReplayPlayer


@action("label-dialog")
async def ask(session: PageState, data: Data) -> None:
    """Ask by which features the agent may have chosen among which behaviors."""
    if session.status is None:
        raise SwarmError("Choose an agent of the recording first.")
    domain = named_domain(session.status.domain)
    session.dialog = {"kind": "label", "agent": session.agent, "domain": domain}


@action("label")
async def label(session: PageState, data: Data) -> None:
    """Find which behavior each moment of what the agent did was."""
    player, dialog, chosen = player_of(session), session.dialog, data["values"]
    features, behaviors = chosen.get("features", []), chosen.get("states", [])

    def made() -> Labels:
        driven = driving_of(player.recording.path, dialog["agent"])
        strip = Strip(driven.moments, dialog["domain"], driven.agent, behaviors, features)
        return Labels(strip, driven.start - player.recording.start)

    player.labels = await meanwhile_busy(session, made)
    session.close_dialog()


@action("label-span", repeats=True)
async def look_at_span(session: PageState, data: Data) -> None:
    """Look at a span: go to where it begins."""
    player = player_of(session)
    labels, span = _labels(player), _span(player, int(data["number"]))
    labels.chosen = int(data["number"])
    player.playing = False
    player.seek(span.begin + labels.offset)
    session.show_moment()


@action("label-was")
async def correct(session: PageState, data: Data) -> None:
    """Say what a span was, and label the rest again."""
    player = player_of(session)
    labels, span = _labels(player), _span(player, int(data["number"]))

    def corrected() -> None:
        before = dict(labels.strip.known)
        labels.strip.correct(span.begin, span.end, str(data["value"]))
        try:
            labels.strip.label()
        except Exception:
            labels.strip.known = before
            raise

    await meanwhile_busy(session, corrected)
    spans = enumerate(labels.strip.spans)
    labels.chosen = next((i for i, s in spans if s.begin <= span.begin < s.end), -1)


@action("label-train")
async def train(session: PageState, data: Data) -> None:
    """Train a behavior from the labels, into the library of the agent in the swarm."""
    player, name = player_of(session), str(data["values"].get("name", "")).strip()
    strip, source = _labels(player).strip, player.recording.path.name
    session.look_at(strip.agent)
    session.player = None  # what follows concerns the swarm
    try:
        await change_library(
            session, lambda library: strip.train(name, library, source), f"{name} is trained"
        )
    except Exception:
        session.player = player
        raise
    session.tab, session.behavior = "library", name
    session.show_again()


def _labels(player: ReplayPlayer) -> Labels:
    if player.labels is None:
        raise SwarmError("Nothing is labeled yet.")
    return player.labels


def _span(player: ReplayPlayer, number: int) -> Span:
    spans = _labels(player).strip.spans
    if not 0 <= number < len(spans):
        raise SwarmError("The strip has changed meanwhile: choose again.")
    return spans[number]
