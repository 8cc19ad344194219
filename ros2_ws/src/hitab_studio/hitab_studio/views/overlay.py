"""The overlay of the field: the agent's activity, and the buttons for commands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hitab_core import FLAGS, START, BoundedNumber, Fix, Term, some
from hitab_ros.names import WORLD
from hitab_studio.actions.teaching_actions import targets_asked, targets_meant
from hitab_studio.pages import unavailable
from hitab_studio.pages.looking_back import (
    SURE,
    is_frozen,
    path_of,
    preview_of,
    rows_shown,
    seconds_ago,
)
from hitab_studio.pages.page import Page
from hitab_studio.pages.page_parts import TutorialProgress
from hitab_studio.swarm.absence import absence, silent_machines
from hitab_studio.swarm.launcher import NONE, unknown
from hitab_studio.views import robot_sensors
from hitab_studio.views.label_strip import strip
from hitab_studio.views.perceived import plotted
from hitab_studio.views.tab_swarm import choices

MODE_WORDS = {
    "idle": ("Idle", "no behavior runs"),
    "performing": ("Performing", ""),
    "training": ("Training", "you decide: each command teaches"),
    "testing": ("Testing", "the trained behavior decides"),
}


def context(page: Page) -> dict[str, Any]:
    """Return the variables of the overlay's template."""
    status = page.status
    live = page.player is None
    mode = status.mode if status is not None else ""
    nothing = empty(page)
    known, launch = page.studio.known, page.studio.launcher.launch
    world_absent = absence(known, WORLD) if live else None
    faults = list(status.faults) if status is not None else []
    may_not_act = live and any(
        remedy.code == Fix.ARM.name for remedy in (status.remedies if status is not None else ())
    )
    return {
        "absent": absence(known, page.agent) if live and page.agent else None,
        "world_absent": world_absent,
        "runs_on": known.machine_of.get(page.agent, "") if live else "",
        "silent_machines": silent_machines(known) if live else {},
        **_times(page),
        "stale": live and bool(world_absent or nothing[0]),
        "lost_off": _lost_off(page),
        "stuck": _stuck(page),
        "mode": mode,
        "mode_words": MODE_WORDS.get(mode, ("", "")),
        "buttons": _buttons(page),
        "targets": _targets(page),
        "shown_numbers": _shown_numbers(page),
        "arrow": _arrow(page),
        "legend": _legend(page),
        "camera": robot_sensors.camera(page),
        "stopped": "; ".join(faults) if may_not_act else "",
        "faults": [] if may_not_act else faults,
        "strip": strip(page),
        "empty": nothing,
        "plots": plotted(page),
        "choices": choices(page) if nothing[0] else [],
        "launch": launch,
        "making": page.studio.making if live else None,
        "expected": len(known.target.agents) if launch and known.target is not None else 0,
        "there": sum(map(known.answers, known.agents)) if launch else 0,
        **_to_start(page),
        "kept": page.training is not None and mode in ("idle", "performing"),
        "offers_tutorial": live and _offers_tutorial(page.tutorial),
    }


def _times(page: Page) -> dict[str, Any]:
    """Return the variables of the strip, and of a moment that is past."""
    status, world = page.status, page.studio.known.world if page.player is None else None
    held = (world is not None and world.held) or getattr(status, "held", "")
    return {
        "past": page.time.past,
        "ago": seconds_ago(page),
        "path": path_of(page),
        "preview": preview_of(page),
        "held": held,
        "frozen": is_frozen(page),
        "back_off": unavailable.going_back(page),
        "rows": rows_shown(page),
    }


def _offers_tutorial(progress: TutorialProgress) -> bool:
    """Whether to offer the tutorial: to those who have not finished it."""
    return progress.is_known and not (progress.is_open or progress.is_finished)


def _lost_off(page: Page) -> str:
    """Return the reason for which a lost command cannot be sent again at present."""
    lost = page.lost
    absent = absence(page.studio.known, lost.agent) if lost is not None else None
    return f"{lost.agent} {absent.what}: wait until it answers." if lost and absent else ""


def _stuck(page: Page) -> str:
    """Return the reason for which a tested agent does nothing; "" if it does something."""
    status, training = page.status, page.training
    if status is None or status.mode != "testing" or training is None or page.player:
        return ""
    world = page.studio.known.world
    state = status.active_path[0] if status.active_path else START
    if state != START and state not in FLAGS:
        leads_to = {e.next_state for e in training.examples if e.state == state}
        if leads_to <= {state}:
            return (
                f"No example leads out of {state}, so {page.agent} stays there. Press Restart, or "
                "take over (T) and command the next behavior."
            )
    if world is not None and world.mode == "paused":
        return "The world is paused: press Space to test the trained behavior."
    return ""


def _legend(page: Page) -> list[tuple[str, str]]:
    """Return the active states of the agents, with their colors."""
    palette = page.studio.palette
    active = {state for _, state in page.moment.doing().values() if state}
    return [(s, palette.color(s)) for s in palette.states if s in active][:8]


def empty(page: Page) -> tuple[str, str, str]:
    """Return title, explanation and command line shown in place of a missing field."""
    known, launch = page.studio.known, page.studio.launcher.launch
    target, finds = known.target, "This page then connects by itself."
    here = "here or in a terminal" if startable(page) else "in a terminal"
    if page.moment.shown is not None:
        return ("", "", "")
    if launch is not None and launch.status is None:
        return (f"{'Starting' if launch.verb == 'up' else 'Stopping'} {launch.swarm} …", "", "")
    if target is not None and target.choices and target.problem:
        return ("Which swarm?", target.problem, "")
    if target is not None and target.problem.endswith("is not up."):
        name = target.swarm
        if not name or (why := unknown(name)):
            return (f"{name or 'The swarm'} is not up", f"{why if name else ''} {finds}", "")
        return (f"{name} is not up", f"Start it {here}. {finds}", f"hitab up {name}")
    if target is not None and target.problem:
        return ("Not connected to a swarm", f"{target.problem} {finds}", "")
    if known.statuses and target is not None and not target.world:
        return (
            "No robot has a place yet",
            "The agents are in no simulated world, and no odometry and no tf says where their "
            "robots are. Choose an agent to see its sensors, and train it as any other.",
            "",
        )
    if target is not None and target.swarm:
        where = f"No process of the swarm answers yet in ROS domain {target.domain_id}."
        return (f"Waiting for {target.swarm}", where, "")
    if known.elsewhere:
        return (
            "No swarm of yours is up",
            "Started elsewhere (from another HITAB_HOME, user or computer), and left alone: "
            f"{some(known.elsewhere)}. To use one nevertheless, start a studio for it:",
            f"hitab studio {known.elsewhere[0]}",
        )
    return ("No swarm is up", f"Start one {here}. {finds}", f"hitab up {_proposed(page)}")


def _to_start(page: Page) -> dict[str, Any]:
    """Return the swarms that may be started, and the chosen one."""
    swarms = NONE if page.studio.launcher.is_busy else startable(page)
    name = _proposed(page)
    return {"startable": swarms, "to_start": name if name in swarms else next(iter(swarms), "")}


def _proposed(page: Page) -> str:
    """Return the swarm that the page proposes to start: the chosen one, or else keepaway."""
    return page.to_start or "keepaway"


def startable(page: Page) -> Mapping[str, str]:
    """Return descriptions of the swarms that may be started, by name; {} while one is up."""
    known = page.studio.known
    target = known.target
    up = target is not None and (target.choices or (target.swarm and not target.problem))
    return NONE if up or known.shown or known.statuses else page.studio.launcher.startable


def _buttons(page: Page) -> list[dict[str, Any]]:
    """Return the behaviors that may be commanded: the training's choice, or else all."""
    status, watched = page.status, page.watched
    vocabulary, training = watched.vocabulary, page.training
    if status is None or page.player is not None or not vocabulary.behaviors:
        return []
    keys = page.studio.keys
    names = keys.commandable(
        vocabulary.domain,
        vocabulary.behaviors,
        vocabulary.trained,
        training if page.is_training else None,
    )
    active, preview = next(iter(path_of(page)), ""), preview_of(page)
    if status.mode == "performing":
        active = status.behavior
    return [
        {
            "behavior": name,
            "description": vocabulary.behavior_descriptions.get(Term.parse(name).name, ""),
            "key": keys.of(vocabulary.domain, name),
            "kind": _kind(name, vocabulary.trained),
            "active": name == active,
            "agrees": _sureness(preview) if preview and name == preview.state else "",
            "one_shot": Term.parse(name).name in vocabulary.one_shot,
        }
        for name in names
    ]


def _sureness(preview: Any) -> str:
    """Return how sure an agent is of what it would do: full, half or unsure."""
    return "unsure" if preview.unsure else "full" if preview.probability >= SURE else "half"


def _shown_numbers(page: Page) -> tuple[BoundedNumber, ...]:
    """Return the numbers of the behavior whose form is open."""
    if page.shown_numbers is None:
        return ()
    return page.watched.vocabulary.numbers_of(page.shown_numbers.behavior)


def _arrow(page: Page) -> BoundedNumber | None:
    """Return the number set by an arrow from the agent, relative to the agent's heading.

    None if there is no such number, or with a target, to which a direction may be relative.
    """
    if page.shown_numbers is None or Term.parse(page.shown_numbers.behavior).arguments:
        return None
    return next((n for n in _shown_numbers(page) if n.circular), None)


def _kind(name: str, trained: frozenset[str]) -> str:
    bare = Term.parse(name).name
    if bare in FLAGS:
        return "flag"
    return "trained" if bare in trained else "basic"


def _targets(page: Page) -> list[tuple[str, bool]]:
    """Return the targets to choose from, each with whether a selected thing stands for it."""
    meant = {t for name in page.chosen for t in targets_meant(page, name)}
    return [(t, t in meant) for t in targets_asked(page)]
