"""Actions for demonstrating: commands, trainings, and holding agents."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from hitab_client import (
    ACKNOWLEDGE_SECONDS,
    SwarmClient,
    SwarmError,
    demonstrating,
    is_answered,
)
from hitab_core import Term, with_numbers
from hitab_ros.timing import PROMPT_S
from hitab_studio.actions.registry import Data, action, number_from
from hitab_studio.actions.world_actions import paused
from hitab_studio.page import CHOOSE_FIRST, Page
from hitab_studio.page_parts import MissingTargets, ShownNumbers
from hitab_studio.swarm_link import Connected
from hitab_studio.ui_remedies import answer_text
from hitab_studio.unanswered_command import UnansweredCommand
from hitab_studio.unavailable import nothing_in_training


@action("command")
async def command(page: Page, data: Data) -> None:
    """Command a behavior; first ask for missing targets and numbers."""
    keys = dict(zip("123456789", targets_asked(page), strict=False))
    if (given := keys.get(str(data.get("hotkey")))) is not None:
        await give_target(page, given)  # pressed before the page showed the targets
        return
    page.shown_numbers = page.missing_targets = None
    behavior, seen = str(data["behavior"]), int(data.get("seen") or 0)
    parameters = Term.parse(behavior).arguments
    open_ = [p for p in parameters if p not in page.watched.vocabulary.targets]
    training = page.training
    if training is not None:
        open_ = [p for p in open_ if p not in training.parameters]
    if open_:
        page.missing_targets = MissingTargets(Term.parse(behavior).name, tuple(parameters), seen)
        return
    if numbers := page.watched.vocabulary.numbers_of(behavior):
        begin = {n.name: min(max(0.0, n.low), n.high) for n in numbers}
        page.shown_numbers = ShownNumbers(behavior, begin)
        return
    await _commanded(page, behavior, seen)


@action("show", repeats=True)
async def show(page: Page, data: Data) -> None:
    """Command the behavior of the open form, with the numbers of the form or of an arrow."""
    shown = page.shown_numbers
    if shown is None:
        return  # the form was closed while the arrow was drawn
    for name in shown.values:
        shown.values[name] = number_from(data["values"], name)
    numbers = page.watched.vocabulary.numbers_of(shown.behavior)
    given = [shown.values[number.name] for number in numbers]
    meant = with_numbers(Term.parse(shown.behavior), given, numbers)
    await _commanded(page, str(meant), int(data.get("seen") or 0))


async def _commanded(page: Page, behavior: str, seen: int, sequence: int = 0) -> None:
    """Command a behavior, and offer to send a lost command again.

    Args:
        page: page of the command.
        behavior: the behavior, with targets.
        seen: the world's cycle that the page showed when the person pressed the key.
        sequence: number of a lost command that is sent again; 0 for a new command.
    """
    agent, number, sent = page.agent, sequence or time.time_ns() // 1000, False
    taken = False
    learns = page.is_training
    # Discovery of an agent that was restarted meanwhile takes time.
    seconds = ACKNOWLEDGE_SECONDS if sequence else PROMPT_S
    demonstrator = page.demonstrator

    async def sending(swarm: Connected, agent: str) -> None:
        nonlocal sent
        sent = True
        await demonstrating.command.coroutine(
            swarm.agents,
            swarm.world,
            agent,
            behavior,
            seen=seen,
            sequence=number,
            seconds=seconds,
            demonstrator=demonstrator,
        )

    try:
        if page.lost is not None and page.unseen.there:
            raise SwarmError(f"{behavior} is left out: {page.lost.behavior} was not taken")
        page.lost = None
        await page.ask_agent(sending)
        taken = True
    except SwarmError:
        known = page.studio.known
        status = known.statuses.get(agent)
        if not sent or status is None or is_answered(status, number):
            raise
        if not learns and known.answers(agent):
            raise
        page.lost = UnansweredCommand(agent, behavior, number if learns else 0)
    else:
        if not learns:
            page.tell(f"{agent} performs {behavior}")
    finally:
        page.unseen.add(agent, taken)


@action("send-again")
async def send_again(page: Page, data: Data) -> None:
    """Send the lost command again."""
    lost = page.lost
    if lost is None:
        return
    page.lost = None
    if lost.agent != page.agent:
        page.look_at(lost.agent)
    await _commanded(page, lost.behavior, int(data.get("seen") or 0), lost.sequence)


@action("leave-lost")
async def leave_lost(page: Page, data: Data) -> None:
    """Drop the lost command."""
    page.lost = None


def targets_meant(page: Page, name: str) -> list[str]:
    """Return the targets for which a thing may stand: its own name, or its kind."""
    targets = page.watched.vocabulary.targets
    if name in targets:
        return [name]
    scene = page.studio.known.scene
    kinds = dict(zip(scene.names, scene.kinds, strict=True)) if scene is not None else {}
    words = set(kinds.get(name, "").split("_")) - {""}
    return [t for t in targets if words & set(t.split("_"))]


def targets_asked(page: Page) -> list[str]:
    """Return the targets to choose from for the commanded behavior; [] if none is missing."""
    if page.missing_targets is None:
        return []
    training = page.training
    parameters = training.parameters if training is not None and page.is_training else ()
    return [*page.watched.vocabulary.targets, *parameters]


async def give_target(page: Page, target: str) -> None:
    """Bind the next missing target, and command the behavior after the last one."""
    missing = page.missing_targets
    if missing is None:
        return
    missing.targets = (*missing.targets, target)
    if len(missing.targets) == len(missing.parameters):
        page.missing_targets = None
        meant = str(Term(missing.behavior, missing.targets))
        await command(page, {"behavior": meant, "seen": missing.seen})


@action("target")
async def target(page: Page, data: Data) -> None:
    """Bind the next missing target."""
    await give_target(page, str(data["name"]))


@action("toggle")
async def toggle(page: Page, data: Data) -> None:
    """Switch between testing the trained behavior and taking over, without a reset."""
    status = page.status
    if (
        status is None
        or status.mode == "idle"
        or (status.mode == "performing" and page.training is None)
    ):
        raise SwarmError(nothing_in_training(page))
    mode = demonstrating.other_mode(status)
    answer = await page.request(SwarmClient.set_mode, mode)
    if mode == "testing" and status.training.questions:
        page.tell(answer_text(answer), "note")


@action("restart")
async def restart(page: Page, data: Data) -> None:
    """Test the trained behavior from Start."""
    await page.request(SwarmClient.set_mode, "testing", restart=True)


@action("idle")
async def idle(page: Page, data: Data) -> None:
    """Stop the agent's behavior; a training is kept."""
    await page.request(SwarmClient.perform, "")


@action("perform")
async def perform_behavior(page: Page, data: Data) -> None:
    """Perform a behavior of the library from its beginning."""
    behavior = str(data["behavior"])
    await page.request(SwarmClient.perform, behavior)
    page.tell(f"{page.agent} performs {behavior}")


@action("take")
async def take(page: Page, data: Data) -> None:
    """Take the agent from another demonstrator, and notify that person."""
    before = page.studio.held.get(page.agent, page)
    page.studio.held[page.agent] = page
    if before is not page:
        before.tell(f"{page.name} has taken {page.agent}", "bad")
    page.tell(f"{page.agent} is yours")
    page.studio.touch()


@action("release")
async def release(page: Page, data: Data) -> None:
    """Release the agent for other demonstrators."""
    if not page.locked:
        page.studio.held.pop(page.agent, None)
    page.studio.touch()


@action("new")
async def new(page: Page, data: Data) -> None:
    """Open the dialog to begin a training."""
    if not page.agent:
        raise SwarmError(CHOOSE_FIRST)
    name, resume = str(data.get("name", "")), str(data.get("resume", ""))
    page.open_dialog("new", resume=resume, name=name, typed=name, parameter="")
    page.studio.link.probe(page.agent, on=True)


@action("discard")
async def discard(page: Page, data: Data) -> None:
    """Discard the training; first confirm if examples would be lost."""
    status = page.status
    if status is None or not page.is_training:
        return
    if status.training.examples:
        page.open_dialog("discard", name=status.behavior, examples=status.training.examples)
    else:
        await discard_now(page, data)


@action("discard-now")
async def discard_now(page: Page, data: Data) -> None:
    """Discard the training and its examples."""
    answer = await page.request(SwarmClient.discard)
    page.dialog = {}
    page.lost = page.missing_targets = page.shown_numbers = None
    page.tell(answer_text(answer))


@action("new-name", repeats=True)
async def new_name(page: Page, data: Data) -> None:
    """Warn if a saved behavior has the typed name."""
    if page.dialog.get("kind") != "new":
        return  # the dialog was closed before the last key arrived
    page.dialog["typed"] = name = str(data["value"]).strip()
    if name in page.watched.vocabulary.trained:
        page.studio.link.want(page.agent, name)


@action("new-parameter", repeats=True)
async def new_parameter(page: Page, data: Data) -> None:
    """Offer features and behaviors with the typed parameter, too."""
    if page.dialog.get("kind") == "new":
        page.dialog["parameter"] = str(data["value"]).strip()


@action("begin")
async def begin(page: Page, data: Data) -> None:
    """Begin a training."""
    values: Mapping[str, Any] = data["values"]
    name = str(values.get("name", "")).strip()
    if not name:
        raise SwarmError("Give the behavior a name.")
    parameter = str(values.get("parameter", "")).strip()
    resume = str(values.get("resume", ""))
    fields: dict[str, Any] = {
        "features": [str(f) for f in values.get("features", [])],
        "states": [str(s) for s in values.get("states", [])],
        "parameters": [parameter] if parameter else [],
        "arguments": [str(values.get("target", ""))] if parameter else [],
        "resume": resume,
        "discard": values.get("discard") == "on",
    }
    if not fields["features"] and not resume:
        raise SwarmError(
            "Choose at least one feature for the decisions to depend on: without one, all "
            "situations look the same. You can exchange it later (Features…)."
        )
    if not resume and name in page.watched.vocabulary.trained:
        shown, page.dialog["typed"] = page.dialog.get("typed"), name
        if shown != name:  # a fast typist has not seen the warning yet
            raise SwarmError(f"{name} is saved already, see above. Begin replaces it.")
    await page.request(SwarmClient.begin, name, **fields)
    if values.get("pause") == "on" and await page.ask_world(paused):
        page.tell("The world is paused; Space lets it run")
    page.close_dialog()
    page.tab = "teach"
    page.level = page.state = ""
    page.tell(f"{page.agent} is being trained: {name}")
