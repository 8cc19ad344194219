"""The overlay of the field: what the agent does, who is in control, and what to command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hitab_client.commands import called
from hitab_core import FLAGS, START, Do, Use, some
from hitab_ros.names import WORLD
from hitab_studio import unavailable
from hitab_studio.absence import absence
from hitab_studio.actions.teaching import targets_meant
from hitab_studio.launching import Startable, unknown
from hitab_studio.learned import is_taken_out
from hitab_studio.markers import STATE_COLORS
from hitab_studio.session import Session
from hitab_studio.views import sensors
from hitab_studio.views.choices import choices

MODE_WORDS = {
    "idle": ("Idle", "no behavior runs"),
    "performing": ("Performing", "a saved automaton decides"),
    "training": ("Training", "you decide: each command teaches"),
    "testing": ("Testing", "what was learned decides"),
}


@dataclass(frozen=True)
class Button:
    """A behavior to be commanded."""

    behavior: str
    description: str
    key: str
    kind: str
    active: bool
    one_shot: bool


def context(session: Session) -> dict[str, Any]:
    """Return what the overlay shows."""
    status = session.status
    holder = session.shared.locks.holder(session.agent) if session.agent else None
    live = session.player is None
    mode = status.mode if status is not None else ""
    empty = _empty(session)
    known, launch = session.shared.store.known, session.shared.launcher.launch
    world_absent = absence(known, WORLD) if live else None
    history = session.watched.history
    return {
        "absent": absence(known, session.agent) if live and session.agent else None,
        "world_absent": world_absent,
        "stale": live and bool(world_absent or empty[0]),
        "lost": session.lost,
        "lost_off": _lost_off(session),
        "agent_off": unavailable.agent(session),
        "undo_off": unavailable.undoing(session),
        "redo_off": unavailable.redoing(session),
        "earlier_off": unavailable.retiming(session),
        "test_off": unavailable.testing(session),
        "save_off": unavailable.saving(session),
        "switch_off": unavailable.switching(session),
        "command_off": unavailable.commanding(session),
        "raise_off": unavailable.raising(session),
        "last_done": history.done[-1] if history.done else "",
        "stuck": _stuck(session),
        "note": status.note if status is not None else "",
        "agent": session.agent,
        "status": status,
        "mode": mode,
        "mode_words": (MODE_WORDS.get(mode, ("", ""))[0], _decides(session, mode)),
        "path": list(status.active_path) if status is not None else [],
        "lock": None if holder is None or holder.session == session.id else holder.name,
        "buttons": _buttons(session),
        "asked": session.asked,
        "targets": _targets(session),
        "legend": _legend(session),
        "camera": sensors.camera(session),
        "silent_sensors": sensors.silent(session),
        "stopped": _stopped(session),
        "player": session.player,
        "empty": empty,
        "choices": choices(session) if empty[0] else [],
        "launch": launch,
        "making": session.shared.generations.making if live else None,
        "expected": len(known.target.agents) if launch and known.target is not None else 0,
        "there": sum(map(known.answers, known.agents)) if launch else 0,
        **_to_start(session),
        "busy": session.busy > 0,
        "kept": session.watched.training is not None and mode in ("idle", "performing"),
    }


def _stopped(session: Session) -> str:
    """Return why the robot of the agent may not act; empty: it may."""
    status = session.status if session.player is None else None
    if status is None or all(remedy.code != Do.ARM.name for remedy in status.remedies):
        return ""
    return "; ".join(status.faults)


def _decides(session: Session, mode: str) -> str:
    """Say who decides what the agent does."""
    words = MODE_WORDS.get(mode, ("", ""))[1]
    if mode != "performing" or not session.status.behavior:
        return words
    name = Use.parse(session.status.behavior).name
    behavior = session.watched.behaviors.get(name)
    if name in session.watched.vocabulary.trained or behavior is None:
        return words if name in session.watched.vocabulary.trained else ""
    if is_taken_out(behavior):
        return "it was taken out: nothing decides"
    return "a hand-written automaton decides" if behavior.is_automaton else "a basic behavior runs"


def _lost_off(session: Session) -> str:
    """Return why a lost command cannot be sent again now."""
    lost = session.lost
    absent = absence(session.shared.store.known, lost.agent) if lost is not None else None
    return f"{lost.agent} {absent}: wait until it answers." if lost and absent else ""


def _stuck(session: Session) -> str:
    """Say why nothing happens while what was learned is tested, if nothing does."""
    status, training = session.status, session.watched.training
    if empty := _taken_out(session):
        return (
            f"{empty} was taken out of the robot's domain (`without:` in the swarm file): it does "
            "nothing until it is trained, or given by another agent."
        )
    if status is None or status.mode != "testing" or training is None or session.player:
        return ""
    world = session.shared.store.known.world
    state = status.active_path[0] if status.active_path else START
    if state != START and state not in FLAGS:
        leads_to = {e.next_state for e in training.examples if e.state == state}
        if leads_to <= {state}:
            return (
                f"It is in {state}, and no example leads out of {state}: it stays there. Press "
                "Restart, or take over (T) and show what comes next."
            )
    if world is not None and world.mode == "paused":
        return "The world is paused: press Space, and it does what it has learned."
    return ""


def _taken_out(session: Session) -> str:
    """Return the active automaton that does nothing because it was taken out; "" if none is."""
    status = session.status
    if status is None or session.player is not None:
        return ""
    found = session.watched.behaviors
    names = [Use.parse(label).name for label in (status.behavior, *status.active_path) if label]
    return next((n for n in names if n in found and is_taken_out(found[n])), "")


def _legend(session: Session) -> list[tuple[str, str]]:
    """Return the states that are active at the moment, with their colors."""
    palette = session.shared.store.palette
    player = session.player
    doing = (
        session.shared.store.known.doing() if player is None else player.recording.doing(player.at)
    )
    active = {state for _, state in doing.values() if state}
    return [(s, STATE_COLORS[palette.index(s)]) for s in palette.states if s in active][:8]


def _empty(session: Session) -> tuple[str, str, str]:
    """Return a title, an explanation and what to type, for when there is no field to show."""
    store = session.shared.store
    if session.player is not None or store.known.shown is not None:
        return ("", "", "")
    target, launch = store.known.target, session.shared.launcher.launch
    if launch is not None and launch.status is None:
        doing = "Starting" if launch.verb == "up" else "Stopping"
        what = "This page shows it as soon as it answers." if launch.verb == "up" else ""
        return (f"{doing} {launch.swarm} …", what, "")
    if target is not None and target.problem.endswith("is not up."):
        return _not_up(session, target.swarm)
    if target is not None and target.problem:
        if target.choices:
            return ("Which swarm?", target.problem, "")
        return (
            "Not connected to a swarm",
            f"{target.problem} This page connects by itself as soon as it can.",
            "",
        )
    if store.known.statuses and target is not None and target.world:
        return (f"Waiting for the world of {target.swarm}", "It does not answer yet.", "")
    if store.known.statuses:
        return (
            "No robot has a place yet",
            "The agents are in no simulated world, and no odometry and no tf says where their "
            "robots are. Choose an agent to see its sensors, and train it as any other.",
            "",
        )
    if target is not None and target.swarm and target.swarm == target.identity:
        where = f"ROS domain {target.domain_id}"
        return (
            f"Waiting for {target.swarm}",
            f"It was not started from here, and nothing of it answers in {where}.",
            "",
        )
    if target is not None and target.swarm:
        return (f"Waiting for {target.swarm}", "It is up but does not answer yet.", "")
    if store.known.elsewhere:
        return (
            "No swarm of yours is up",
            "Started elsewhere (from another HITAB_HOME, user or computer), and left alone: "
            f"{some(store.known.elsewhere)}. To use one nevertheless, start a studio for it:",
            f"{called()} studio {store.known.elsewhere[0]}",
        )
    return (
        "No swarm is up",
        "Start one here or in a terminal. This page finds it by itself."
        if startable(session)
        else "Start one in a terminal. This page finds it by itself.",
        f"{called()} up {_proposed(session)}",
    )


def _not_up(session: Session, name: str) -> tuple[str, str, str]:
    """Return the same for a swarm that was asked for and is not up."""
    finds = "This page finds it by itself."
    if not name:
        return ("The swarm is not up", f"Start it in a terminal. {finds}", "")
    if why := unknown(name):
        return (f"{name} is not up", f"{why} {finds}", "")
    where = "here or in a terminal" if startable(session) else "in a terminal"
    return (f"{name} is not up", f"Start it {where}. {finds}", f"{called()} up {name}")


def _to_start(session: Session) -> dict[str, Any]:
    """Return the swarms to choose from, and the one that is chosen to be started."""
    swarms = () if session.shared.launcher.is_busy else startable(session)
    name = _proposed(session)
    chosen = next((swarm for swarm in swarms if swarm.name == name), None)
    return {"startable": swarms, "to_start": chosen or (swarms[0] if swarms else None)}


def _proposed(session: Session) -> str:
    """Return the swarm that is proposed to be started: the chosen one, else keepaway."""
    return session.to_start or "keepaway"


def startable(session: Session) -> tuple[Startable, ...]:
    """Return the swarms that may be started now: none if one is up."""
    known = session.shared.store.known
    if known.target is not None and known.target.choices:
        return ()
    up = known.target is not None and known.target.swarm and not known.target.problem
    return () if up or known.shown or known.statuses else session.shared.launcher.startable


def _buttons(session: Session) -> list[Button]:
    """Return the behaviors that may be commanded: those chosen for the training, else all."""
    status, watched = session.status, session.watched
    vocabulary, training = watched.vocabulary, watched.training
    if status is None or session.player is not None or not vocabulary.behaviors:
        return []
    keys = session.shared.keys
    of_training: dict[str, Any] = {}
    if session.is_training and training is not None:
        of_training = {
            "training": training.name,
            "chosen": training.chosen,
            "states": training.states,
        }
    names = keys.commandable(
        vocabulary.domain, vocabulary.behaviors, vocabulary.trained, **of_training
    )
    active = status.active_path[0] if status.active_path else ""
    if status.mode == "performing":
        active = status.behavior
    return [
        Button(
            behavior=name,
            description=vocabulary.behavior_descriptions.get(Use.parse(name).name, ""),
            key=keys.of(vocabulary.domain, name),
            kind=_kind(name, vocabulary.trained),
            active=name == active,
            one_shot=Use.parse(name).name in vocabulary.one_shot,
        )
        for name in names
    ]


def _kind(name: str, trained: frozenset[str]) -> str:
    bare = Use.parse(name).name
    if bare in FLAGS:
        return "flag"
    return "trained" if bare in trained else "basic"


def _targets(session: Session) -> list[tuple[str, bool]]:
    """Return the targets that may be given, with whether what is chosen in the field means it."""
    if session.asked is None:
        return []
    training = session.watched.training
    parameters = training.parameters if training is not None and session.is_training else ()
    meant = {t for name in session.chosen for t in targets_meant(session, name)}
    return [(t, t in meant) for t in (*session.watched.vocabulary.targets, *parameters)]
