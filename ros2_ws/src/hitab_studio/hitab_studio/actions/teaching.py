"""Demonstrating: commands, taking over and handing back."""

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
from hitab_core import Use, with_numbers
from hitab_studio.actions.arranging import paused
from hitab_studio.actions.registry import Data, action, number_from
from hitab_studio.page_state import (
    CHOOSE_FIRST,
    MissingTargets,
    PageState,
    ShownNumbers,
    nothing_in_training,
)
from hitab_studio.swarm_link import Connected
from hitab_studio.ui_remedies import answered
from hitab_studio.unanswered_command import TAKEN_SECONDS, UnansweredCommand


@action("command")
async def command(session: PageState, data: Data) -> None:
    """Command a behavior; first ask for targets and numbers, if it takes some."""
    keys = dict(zip("123456789", targets_asked(session), strict=False))
    if (given := keys.get(str(data.get("hotkey")))) is not None:
        await give_target(session, given)  # pressed before the page showed the targets
        return
    session.shown_numbers = session.missing_targets = None
    behavior, seen = str(data["behavior"]), int(data.get("seen") or 0)
    parameters = Use.parse(behavior).arguments
    open_ = [p for p in parameters if p not in session.watched.vocabulary.targets]
    training = session.training
    if training is not None:
        open_ = [p for p in open_ if p not in training.parameters]
    if open_:
        session.missing_targets = MissingTargets(Use.parse(behavior).name, tuple(parameters), seen)
        return
    if numbers := session.watched.vocabulary.numbers_of(behavior):
        begin = {n.name: min(max(0.0, n.low), n.high) for n in numbers}
        session.shown_numbers = ShownNumbers(behavior, begin)
        return
    await _commanded(session, behavior, seen)


@action("show", repeats=True)
async def show(session: PageState, data: Data) -> None:
    """Command the behavior that is shown with the numbers of its form, or of an arrow."""
    shown = session.shown_numbers
    if shown is None:
        return  # it was closed while the arrow was drawn
    for name in shown.values:
        shown.values[name] = number_from(data["values"], name)
    numbers = session.watched.vocabulary.numbers_of(shown.behavior)
    given = [shown.values[number.name] for number in numbers]
    meant = with_numbers(Use.parse(shown.behavior), given, numbers)
    await _commanded(session, str(meant), int(data.get("seen") or 0))


async def _commanded(session: PageState, behavior: str, seen: int, sequence: int = 0) -> None:
    """Command a behavior, and offer to send the command again if it is lost.

    Args:
        session: of the page.
        behavior: with its targets.
        seen: the world's cycle that the page showed when the person pressed the key.
        sequence: number of a lost command that is sent again; 0 for a new one.
    """
    agent, number, sent = session.agent, sequence or time.time_ns() // 1000, False
    taken = False
    learns = session.is_training
    # An agent that was restarted meanwhile has to be discovered first.
    seconds = ACKNOWLEDGE_SECONDS if sequence else TAKEN_SECONDS
    demonstrator = session.demonstrator

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
        if session.lost is not None and session.unseen.there:
            raise SwarmError(f"{behavior} is left out: {session.lost.behavior} was not taken")
        session.lost = None
        await session.ask_agent(sending)
        taken = True
    except SwarmError:
        known = session.shared.store.known
        status = known.statuses.get(agent)
        if not sent or status is None or is_answered(status, number):
            raise
        if not learns and known.answers(agent):
            raise
        session.lost = UnansweredCommand(agent, behavior, number if learns else 0)
    else:
        if not learns:
            session.tell(f"{agent} performs {behavior}")
    finally:
        session.unseen.add(agent, taken)


@action("send-again")
async def send_again(session: PageState, data: Data) -> None:
    """Send a lost command again."""
    lost = session.lost
    if lost is None:
        return
    session.lost = None
    if lost.agent != session.agent:
        session.look_at(lost.agent)
    await _commanded(session, lost.behavior, int(data.get("seen") or 0), lost.sequence)


@action("leave-lost")
async def leave_lost(session: PageState, data: Data) -> None:
    """Do not send a lost command again."""
    session.lost = None


def targets_meant(session: PageState, name: str) -> list[str]:
    """Return the targets that a click on a thing may mean: itself, or its kind."""
    targets = session.watched.vocabulary.targets
    if name in targets:
        return [name]
    scene = session.shared.store.known.scene
    kinds = dict(zip(scene.names, scene.kinds, strict=True)) if scene is not None else {}
    words = set(kinds.get(name, "").split("_")) - {""}
    return [t for t in targets if words & set(t.split("_"))]


def targets_asked(session: PageState) -> list[str]:
    """Return the targets that may be given to what was commanded; none if it needs none."""
    if session.missing_targets is None:
        return []
    training = session.training
    parameters = training.parameters if training is not None and session.is_training else ()
    return [*session.watched.vocabulary.targets, *parameters]


async def give_target(session: PageState, target: str) -> None:
    """Bind a requested target; command after the last one."""
    missing = session.missing_targets
    if missing is None:
        return
    missing.targets = (*missing.targets, target)
    if len(missing.targets) == len(missing.parameters):
        session.missing_targets = None
        meant = str(Use(missing.behavior, missing.targets))
        await command(session, {"behavior": meant, "seen": missing.seen})


@action("target")
async def target(session: PageState, data: Data) -> None:
    """Bind a requested target."""
    await give_target(session, str(data["name"]))


@action("toggle")
async def toggle(session: PageState, data: Data) -> None:
    """Switch between testing what was learned and taking over, without a reset."""
    status = session.status
    if (
        status is None
        or status.mode == "idle"
        or (status.mode == "performing" and session.training is None)
    ):
        raise SwarmError(nothing_in_training(session))
    mode = demonstrating.other_mode(status)
    answer = await session.request(SwarmClient.set_mode, mode)
    if mode == "testing" and status.questions:
        session.tell(answered(answer), "note")


@action("restart")
async def restart(session: PageState, data: Data) -> None:
    """Test from Start."""
    await session.request(SwarmClient.set_mode, "testing", restart=True)


@action("idle")
async def idle(session: PageState, data: Data) -> None:
    """Have the agent perform nothing; a training is kept."""
    await session.request(SwarmClient.perform, "")


@action("perform")
async def perform_behavior(session: PageState, data: Data) -> None:
    """Perform a behavior of the library from its beginning."""
    behavior = str(data["behavior"])
    await session.request(SwarmClient.perform, behavior)
    session.tell(f"{session.agent} performs {behavior}")


@action("take")
async def take(session: PageState, data: Data) -> None:
    """Take an agent from another demonstrator and notify that one."""
    before = session.shared.held.get(session.agent, session)
    session.shared.held[session.agent] = session
    if before is not session:
        before.tell(f"{session.name} has taken {session.agent}", "bad")
    session.tell(f"{session.agent} is yours")
    session.shared.store.touch()


@action("release")
async def release(session: PageState, data: Data) -> None:
    """Release an agent."""
    if not session.locked:
        session.shared.held.pop(session.agent, None)
    session.shared.store.touch()


@action("new")
async def new(session: PageState, data: Data) -> None:
    """Ask what to train."""
    if not session.agent:
        raise SwarmError(CHOOSE_FIRST)
    session.dialog = {
        "kind": "new",
        "agent": session.agent,
        "resume": str(data.get("resume", "")),
        "name": str(data.get("name", "")),
        "typed": str(data.get("name", "")),
        "parameter": "",
    }
    session.shared.link.probe(session.agent, on=True)


@action("discard")
async def discard(session: PageState, data: Data) -> None:
    """Give up the training; ask first if examples would be lost."""
    status = session.status
    if status is None or not session.is_training:
        return
    if status.examples:
        session.dialog = {
            "kind": "discard",
            "agent": session.agent,
            "name": status.behavior,
            "examples": status.examples,
        }
    else:
        await discard_now(session, data)


@action("discard-now")
async def discard_now(session: PageState, data: Data) -> None:
    """Give up the training and its examples."""
    answer = await session.request(SwarmClient.discard)
    session.dialog = {}
    session.lost = session.missing_targets = session.shown_numbers = None
    session.tell(answered(answer))


@action("new-name", repeats=True)
async def new_name(session: PageState, data: Data) -> None:
    """Warn if a behavior of this name is saved already."""
    if session.dialog.get("kind") != "new":
        return  # it was closed before the last key was heard of
    session.dialog["typed"] = name = str(data["value"]).strip()
    if name in session.watched.vocabulary.trained:
        session.shared.link.want(session.agent, name)


@action("new-parameter", repeats=True)
async def new_parameter(session: PageState, data: Data) -> None:
    """Also offer features and behaviors of a parameter."""
    if session.dialog.get("kind") == "new":
        session.dialog["parameter"] = str(data["value"]).strip()


@action("begin")
async def begin(session: PageState, data: Data) -> None:
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
            "Choose at least one feature for the decisions to depend on: without one, it cannot "
            "tell situations apart. You can exchange it later (Features…)."
        )
    if not resume and name in session.watched.vocabulary.trained:
        shown, session.dialog["typed"] = session.dialog.get("typed"), name
        if shown != name:  # who is fast has not seen it yet
            raise SwarmError(f"{name} is saved already, see above. Begin replaces it.")
    await session.request(SwarmClient.begin, name, **fields)
    if values.get("pause") == "on" and await session.ask_world(paused):
        session.tell("The world is paused; Space lets it run")
    session.close_dialog()
    session.tab = "teach"
    session.level = session.state = ""
    session.tell(f"{session.agent} is being trained: {name}")
