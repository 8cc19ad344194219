"""The steps of the tutorial, in order: what to do, what to mark, and when it is done."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from hitab_studio.pages.page import Page
from hitab_studio.tutorial.lessons import DIRECTION, FEATURES, KICKABLE, LESSONS, Situation, taught

NAME = "FetchBall"
DOMAIN = "keepaway"
"""Domain of the agents that can learn `NAME`."""

AGENT, BALL = "agent", "ball"
ROOM_M = 4.5
"""Distance from the middle of the field, m, within which there is room around an agent."""

SPOTS = ((0.0, 0.0), (3.0, 0.0), (0.0, 3.0), (-3.0, 0.0), (0.0, -3.0))
"""Places near the middle of the field, m."""

Condition = Callable[[Page], bool]


def tests(*names: str) -> tuple[str, ...]:
    """Return selectors of the elements with these names."""
    return tuple(f'[data-test="{name}"]' for name in names)


def unticked() -> tuple[str, ...]:
    """Return selectors of the boxes of the features that are to be ticked."""
    return tuple(f'[data-test="feature-{name}"]:not(:checked)' for name in FEATURES)


@dataclass(frozen=True)
class TutorialStep:
    """A step of the tutorial.

    Attributes:
        name: identifies the step.
        text: what to do; ``{agent}`` and ``{key}`` (of `behavior`) are filled in.
        marks: selectors; the first element that a person can press is marked.
        done: whether there is nothing to do at present.
        once: whether it stays done from then on, and may be skipped.
        behavior: the behavior whose key is marked; "" if none.
        thing: the thing to drag, `AGENT` for the viewed agent; "" if none.
        spot: returns where to drag it, m.
        is_optional: whether to leave it out on a page without what it marks; it is done once
            that was pressed.
    """

    name: str
    text: str
    marks: tuple[str, ...]
    done: Condition
    once: bool = False
    behavior: str = ""
    thing: str = ""
    spot: Callable[[Page], tuple[float, float]] | None = None
    is_optional: bool = False


def is_ours(page: Page) -> bool:
    """Whether the viewed agent is being trained as the tutorial says."""
    training = page.training
    return page.is_training and training is not None and training.name == NAME


def is_settled(page: Page) -> bool:
    """Whether all that a page knows is of one moment: no answer and no training is to arrive."""
    if page.busy or page.player is not None or not page.is_training:
        return not page.busy
    training, status = page.training, page.status
    # What changes in a test, such as remarks, does not matter.
    wanted = status.training.revision if status.mode == "training" else 0
    return training is not None and training.revision >= wanted


def is_saved(page: Page) -> bool:
    """Whether the page shows what the person has just saved."""
    return not page.is_training and (page.tab, page.behavior) == ("library", NAME)


def _lessons(page: Page) -> tuple[int, bool]:
    training = page.training
    return taught(training) if is_ours(page) and training is not None else (0, False)


def _has_features(page: Page) -> bool:
    training = page.training
    return training is not None and set(FEATURES) <= set(map(str, training.features))


def _place(page: Page, thing: str) -> tuple[float, float, float]:
    scene = page.moment.scene
    if scene is None or thing not in scene.names:
        return (0.0, 0.0, 0.0)
    x, y, heading = scene.places[scene.names.index(thing), :3].tolist()
    return x, y, heading


def _has_room(page: Page) -> bool:
    return _lessons(page)[0] > 0 or math.hypot(*_place(page, page.agent)[:2]) < ROOM_M


def _free_spot(page: Page) -> tuple[float, float]:
    """Return the place near the middle of the field that is farthest from everything else."""
    scene = page.moment.scene
    if scene is None:
        return (0.0, 0.0)
    places = zip(scene.names, scene.places[:, :2].tolist(), strict=True)
    others = [place for name, place in places if name != page.agent]
    return max(SPOTS, key=lambda spot: min((math.dist(spot, at) for at in others), default=0.0))


def _spot(lesson: Situation, page: Page) -> tuple[float, float]:
    x, y, heading = _place(page, page.agent)
    at = heading + math.radians(lesson.bearing)
    return x + lesson.distance * math.cos(at), y + lesson.distance * math.sin(at)


def _is_arranged(lesson: Situation, page: Page) -> bool:
    readings = page.watched.readings
    return lesson.fits({name: readings.get((NAME, name), (math.nan,))[-1] for name in FEATURES})


def _is_mode(page: Page, *modes: str) -> bool:
    return page.status is not None and page.status.mode in modes


def _world(page: Page, mode: str) -> bool:
    return page.studio.known.world is not None and page.studio.known.world.mode == mode


def _slipped(page: Page) -> bool:
    return bool(page.training and page.training.undone) or _lessons(page)[0] > SLIP_AFTER


SLIP_AFTER = 2
"""Number of lessons before the mistake that the person makes to undo it."""

KEYBOARD = "Keyboard: Tab to the field, Page Up or Page Down to choose, arrow keys to move."


def _lesson_steps(number: int, lesson: Situation) -> tuple[TutorialStep, TutorialStep]:
    """Return the steps that arrange the situation of a lesson, and give its command."""

    def is_had(page: Page) -> bool:
        return _lessons(page)[0] > number

    def is_arranged(page: Page) -> bool:
        return is_had(page) or _is_arranged(lesson, page)

    drag = f"Drag the ball into the dashed ring: {lesson.where}."
    press = f"The ball is {lesson.where}. Press {lesson.behavior} ({{key}})."
    return (
        TutorialStep(
            f"arrange-{number}", drag, (), is_arranged, thing=BALL, spot=partial(_spot, lesson)
        ),
        TutorialStep(
            f"command-{number}",
            press,
            tests(f"do-{lesson.behavior}"),
            is_had,
            behavior=lesson.behavior,
        ),
    )


LESSON_STEPS = [step for number, one in enumerate(LESSONS) for step in _lesson_steps(number, one)]

GROUND = (
    TutorialStep(
        "live",
        "This is a recording. Close it (Esc).",
        ('[data-do="replay-close"]',),
        lambda page: page.player is None,
    ),
    TutorialStep(
        "now",
        "You are looking back. Return to now (Esc) to go on.",
        tests("present"),
        lambda page: page.time.past is None,
    ),
    TutorialStep(
        "swarm",
        "Choose keepaway and press Start. It takes a few seconds.",
        tests("swarm-start", "swarm-keepaway"),
        lambda page: bool(page.studio.known.statuses),
    ),
    TutorialStep(
        "keepers",
        "This tutorial needs keepers in a simulated world. In Swarm, stop this swarm; then start "
        "keepaway.",
        tests("stop-now", "swarm-stop", "tab-swarm"),
        lambda page: (
            page.studio.known.world is not None
            and any(status.domain == DOMAIN for status in page.studio.known.statuses.values())
        ),
    ),
    TutorialStep(
        "agent",
        "Choose a keeper.",
        ('[data-test^="agent-keeper"]',),
        lambda page: page.status is not None and page.status.domain == DOMAIN,
    ),
    TutorialStep(
        "free",
        "Someone else holds {agent}. Choose another keeper, or take this one over.",
        tests("take"),
        lambda page: not page.held_by_others(page.agent),
    ),
)
"""What must be so at any time."""

TRAINING = (
    TutorialStep(
        "other",
        "{agent} is learning something else. Save or discard that, or choose another keeper.",
        tests("save-now", "discard-now", "save"),
        lambda page: not page.is_training or page.training is None or is_ours(page),
    ),
    TutorialStep(
        "open",
        "Press Train….",
        tests("new"),
        lambda page: page.is_training or page.dialog.get("kind") == "new",
    ),
    TutorialStep(
        "name",
        f"{{agent}} should turn to the ball, run to it and stop. Type the name {NAME}.",
        tests("new-name"),
        lambda page: page.is_training or page.dialog.get("typed") == NAME,
    ),
    TutorialStep(
        "begin",
        f"Tick what decisions depend on: {KICKABLE} and {DIRECTION}. Then press Begin.",
        (*unticked(), *tests("begin")),
        is_ours,
    ),
    TutorialStep(
        "features",
        f"Decisions need {KICKABLE} and {DIRECTION}. Press Features… and tick them.",
        (*unticked(), *tests("features-accept", "features-change")),
        _has_features,
    ),
    TutorialStep(
        "mend",
        "That command does not fit. Undo it (U).",
        tests("undo"),
        lambda page: not _lessons(page)[1],
    ),
    TutorialStep(
        "teach",
        "Take over (T): you decide.",
        tests("toggle"),
        lambda page: _lessons(page)[0] == len(LESSONS) or _is_mode(page, "training"),
    ),
    TutorialStep(
        "pause",
        "Pause the world (Space), to arrange it without haste.",
        tests("pause"),
        lambda page: _lessons(page)[0] == len(LESSONS) or _world(page, "paused"),
    ),
    TutorialStep(
        "room", "Drag {agent} into the dashed ring.", (), _has_room, thing=AGENT, spot=_free_spot
    ),
    *LESSON_STEPS[: 2 * SLIP_AFTER],
    TutorialStep(
        "slip",
        "Mistakes are easy to mend. Make one: press Stop ({key}), which is wrong here.",
        tests("do-Stop"),
        _slipped,
        once=True,
        behavior="Stop",
    ),
    *LESSON_STEPS[2 * SLIP_AFTER :],
    TutorialStep(
        "preview",
        "This key is what {agent} would do next. Pressing it confirms that, another one corrects.",
        ('.behavior[class*="agrees-"]',),
        lambda page: False,
        once=True,
        is_optional=True,
    ),
    TutorialStep(
        "test",
        "Now it decides itself. Press Test (T).",
        tests("toggle"),
        lambda page: _is_mode(page, "testing"),
        once=True,
    ),
    TutorialStep(
        "run",
        "Let the world run (Space).",
        tests("pause"),
        lambda page: _world(page, "running"),
        once=True,
    ),
    TutorialStep(
        "watch",
        "Watch: {agent} turns to the ball, runs to it and stops. If it does something wrong, "
        "take over (T) and press the right key.",
        tests("banner"),
        lambda page: _world(page, "running") and list(page.status.active_path[:1]) == ["Stop"],
        once=True,
    ),
    TutorialStep("save", "Save it: press Save….", tests("save-now", "save"), is_saved, once=True),
)
"""The training, which is over once the behavior is saved."""

AFTER = (
    TutorialStep(
        "perform",
        f"{NAME} is now a behavior with a key of its own. Press it ({{key}}).",
        tests(f"do-{NAME}"),
        lambda page: _is_mode(page, "performing") and page.status.behavior == NAME,
        once=True,
        behavior=NAME,
    ),
    TutorialStep(
        "back",
        "Go back in time (comma) to see what it did; Esc returns to now.",
        tests("cycle-back"),
        lambda page: False,
        once=True,
        is_optional=True,
    ),
    TutorialStep(
        "end",
        f"Done: {NAME} runs. Distribute… gives it to the others, Train further… continues the "
        "training, and ? lists all keys.",
        tests("distribute"),
        lambda page: False,
    ),
)

STEPS = (*GROUND, *TRAINING, *AFTER)
