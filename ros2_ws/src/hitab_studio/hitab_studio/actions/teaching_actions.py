"""Actions for demonstrating: commands, trainings, and holding agents."""

from __future__ import annotations

import uuid

from hitab_client import SwarmError, demonstrating
from hitab_core import Term, with_numbers
from hitab_core.operations import BeginTraining, DiscardTraining
from hitab_ros.call import RequestRefused
from hitab_ros.timing import ANSWER_S, PROMPT_S
from hitab_studio.actions.operation_actions import carry_out, operation_of
from hitab_studio.actions.registry import Data, action, number_from
from hitab_studio.actions.time_actions import frozen_now, thaw
from hitab_studio.actions.world_actions import paused
from hitab_studio.pages.looking_back import PastMoment, to_present
from hitab_studio.pages.page import CHOOSE_FIRST, Page
from hitab_studio.pages.page_parts import LostCommand, MissingTargets, ShownNumbers


@action("command")
async def command(page: Page, data: Data) -> None:
    """Command a behavior; first ask for missing targets and numbers."""
    keys = dict(zip("123456789", targets_asked(page), strict=False))
    if (given := keys.get(str(data.get("hotkey")))) is not None:
        await give_target(page, given)  # pressed before the page showed the targets
        return
    page.shown_numbers = page.missing_targets = None
    if await frozen_now(page):
        return
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
    await _commanded(page, LostCommand(page.agent, behavior, _identity(data)), seen)


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
    behavior = str(with_numbers(Term.parse(shown.behavior), given, numbers))
    sent = LostCommand(page.agent, behavior, _identity(data))
    await _commanded(page, sent, int(data.get("seen") or 0))


def _identity(data: Data) -> str:
    return str(data.get("id") or uuid.uuid4().hex)


async def _commanded(page: Page, sent: LostCommand, seen: int, seconds: float = PROMPT_S) -> None:
    """Command a behavior, and offer to send the command again if it is not answered.

    Args:
        page: page of the command.
        sent: the command, with the identity that it keeps when it is sent again.
        seen: the world's cycle that the page showed when the person pressed the key.
        seconds: timeout for the answer; discovery of a restarted agent takes time.
    """
    agent, behavior = page.take_agent(), sent.behavior
    by, learns, past = page.demonstrator, page.is_training, page.time.past
    page.lost = None
    if past is not None:
        _check_past(page, past)
    try:
        await page.ask(
            lambda swarm: demonstrating.command.coroutine(
                swarm.agents,
                swarm.world,
                agent,
                behavior,
                seen=past.cycle if past is not None else seen,
                exact=past is not None,
                id=sent.id,
                by=by,
                seconds=seconds,
            ),
            agent,
        )
    except SwarmError as error:
        page.not_taken[agent] = behavior
        if isinstance(error, RequestRefused):
            raise
        page.lost = sent
    else:
        to_present(page)
        await thaw(page)
        if not learns:
            page.tell(f"{agent} performs {behavior}")


def _check_past(page: Page, past: PastMoment) -> None:
    """Refuse a command for a moment from which the agent cannot learn.

    Raises:
        SwarmError: if so.
    """
    if not page.is_training:
        raise SwarmError(
            f"{page.agent} is not being trained, so it learns nothing for a moment that is past. "
            "Press Esc to command it now."
        )
    if not past.cycle:
        raise SwarmError(past.why or f"It is not known which cycle of {page.agent} that was.")


@action("send-again")
async def send_again(page: Page, data: Data) -> None:
    """Send the lost command again."""
    lost = page.lost
    if lost is None:
        return
    page.look_at(lost.agent)
    await _commanded(page, lost, int(data.get("seen") or 0), ANSWER_S)


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
        term = Term(missing.behavior, missing.targets)
        await command(page, {"behavior": str(term), "seen": missing.seen})


@action("target")
async def target(page: Page, data: Data) -> None:
    """Bind the next missing target."""
    await give_target(page, str(data["name"]))


@action("take")
async def take(page: Page, data: Data) -> None:
    """Take the agent from another demonstrator, and notify that person."""
    before = page.studio.held.get(page.agent, page)
    page.studio.held[page.agent] = page
    if before is not page:
        before.tell(f"{page.name} has taken {page.agent}", "bad")
    page.tell(f"{page.agent} is yours")
    page.studio.touch()


@action("new")
async def new(page: Page, data: Data) -> None:
    """Open the dialog to begin a training."""
    if not page.agent:
        raise SwarmError(CHOOSE_FIRST)
    name, resume = str(data.get("name", "")), str(data.get("resume", ""))
    page.open_dialog("new", resume=resume, name=name, typed=name, parameter="")
    page.studio.link.probe(page.agent, on=True)


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


@action("begin_training")
async def begin(page: Page, data: Data) -> None:
    """Begin a training."""
    values = data["values"]
    parameter = str(values.get("parameter", "")).strip()
    bound = {parameter: str(values.get("target", ""))} if parameter else {}
    operation = operation_of(BeginTraining, page, data, parameters=bound)
    name = operation.automaton
    if not name:
        raise SwarmError("Give the behavior a name.")
    if not operation.features and not operation.resume:
        raise SwarmError(
            "Choose at least one feature for the decisions to depend on: without one, all "
            "situations look the same. You can exchange it later (Features…)."
        )
    if not operation.resume and name in page.watched.vocabulary.trained:
        shown, page.dialog["typed"] = page.dialog.get("typed"), name
        if shown != name:  # a fast typist has not seen the warning yet
            raise SwarmError(f"{name} is saved already, see above. Begin replaces it.")
    await carry_out(page, operation)
    if values.get("pause") and await page.ask_world(paused):
        page.tell("The world is paused; Space lets it run")
    page.tab = "teach"
    page.level = page.state = ""


@action("discard_training")
async def discard(page: Page, data: Data) -> None:
    """Discard the training; first confirm if examples would be lost."""
    status = page.status
    if status is None or not page.is_training:
        return
    if status.training.examples and not data.get("sure"):
        page.open_dialog("discard", name=status.behavior, examples=status.training.examples)
        return
    await carry_out(page, operation_of(DiscardTraining, page, data))
    page.lost = page.missing_targets = page.shown_numbers = None
