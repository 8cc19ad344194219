"""The demo of a domain: train its agents over ROS topics, play, and compare."""

from __future__ import annotations

import contextlib
import json
import shlex
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_bringup import (
    RunningSwarm,
    copy_library,
    described_swarm,
    open_library,
    temporary_swarm,
)
from hitab_cli.demo.demo_studio import play_on, studio_beside
from hitab_cli.views import plots
from hitab_cli.views.field_picture import draw_field
from hitab_client import console
from hitab_client.lessons import LessonPlayer, LessonReport, read_lesson
from hitab_client.measures import SECONDS, estimate, values_of
from hitab_client.runs.shipped import find_file
from hitab_client.terminal.cli_remedies import called
from hitab_core import HitabError, has, quantity
from hitab_core.operations import Perform
from hitab_world.demo import DEMO_ENTRY_POINTS, Demo

if TYPE_CHECKING:
    from hitab_msgs.msg import WorldState

PICTURE_CYCLES = 120
PICTURE_MOMENTS = 80
"""Number of last moments of an episode whose paths are drawn."""
LINE_EVERY = 20
"""Number of episodes between two lines of progress, if there is no progress bar."""


def offered_demo(name: str = "") -> Demo:
    """Return a demo of an installed domain; without a name the first one.

    Raises:
        HitabError: if no installed domain offers this demo.
    """
    offered = {point.name: point for point in entry_points(group=DEMO_ENTRY_POINTS)}
    if name not in offered and (name or not offered):
        raise HitabError(f'no installed domain offers a demo "{name}" {has(offered, name)}')
    demo: Demo = offered[name or min(offered)].load()
    return demo


def run_demo(
    demo: Demo,
    out: Path,
    episodes: int,
    seed: int,
    studio_port: int | None = None,
    *,
    browser: bool = True,
) -> dict[str, Any]:
    """Train, play, compare, and write everything to a folder.

    Args:
        demo: the demo to play.
        out: the folder; pictures, figures and the library of an earlier demo are replaced.
        episodes: number to play.
        seed: random seed of the episodes.
        studio_port: port of the studio during the demo; None for no studio.
        browser: whether to open the studio in a browser.

    Returns:
        The figures, as written to ``figures.json``.
    """
    began = time.monotonic()
    out.mkdir(parents=True, exist_ok=True)
    described = described_swarm(demo.swarm, None, pace="lockstep", paused=True)
    with contextlib.ExitStack() as stack:
        stack.callback(_remove_if_empty, out)
        with console.progress(f"starting {demo.swarm}") as advance:
            running = stack.enter_context(temporary_swarm(described, progress=advance))
        agents = quantity(len(described.agents), "agent")
        console.say(f"A world and {agents} are up, each in its own process.\n")
        if studio_port is not None:
            stack.enter_context(studio_beside(running, studio_port, browser=browser))
        reports = _train(running, demo)
        library = Path(reports[-1].path).parent
        evaluation = _evaluate(running, library, demo, episodes, seed)
        moments = _watch(running)
        _keep_library(library, out / "library")
        # With the studio, the swarm stays up after the report.
        staying = contextlib.ExitStack() if studio_port is None else stack.pop_all()
    with staying:
        figures = {
            "lessons": [_row(report) for report in reports],
            "evaluation": evaluation,
            "wall_s": round(time.monotonic() - began, 1),
        }
        _draw_episode_lengths(evaluation, demo, out / "episode_lengths.png")
        draw_field(moments, out / "field.png", f"{demo.swarm}: the ways of the last seconds")
        _draw_automata(out / "library", [r.lesson for r in reports], out / "automata.png")
        (out / "figures.json").write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
        _show(reports, figures, demo, out)
        if studio_port is not None:
            play_on(running)
    return figures


def _remove_if_empty(out: Path) -> None:
    """Remove the folder if the demo was interrupted before it wrote anything."""
    with contextlib.suppress(OSError):
        out.rmdir()


def _train(running: RunningSwarm, demo: Demo) -> list[LessonReport]:
    reports = []
    for name in demo.lessons:
        lesson = read_lesson(find_file(name, "lessons", "lesson"))
        with console.progress(f"teaching {lesson.name}", "steps") as advance:
            report = LessonPlayer(lesson, running.agents, running.world).play(advance)
        reports.append(report)
        console.say(
            f"Taught {report.lesson}: {report.examples} examples from {report.commands} commands"
        )
    return reports


def _evaluate(
    running: RunningSwarm, library: Path, demo: Demo, episodes: int, seed: int
) -> dict[str, Any]:
    """Play episodes in which all agents perform the taught behavior; return the results."""
    for agent in running.record.agents:
        running.agents.do(agent, Perform(demo.behavior))
    world = running.world
    with console.progress("playing", "episodes", line_every=LINE_EVERY) as advance:
        played = world.play(
            episodes, seed, progress=lambda done: advance(done, episodes, "playing episodes")
        )
    # The world pauses by itself after the last episode and reports that.
    running.link.spin_until(
        lambda: world.status is not None and world.status.episodes_left == 0, 3.0
    )
    values = values_of(played)
    return {
        "episodes": len(played),
        "seed": seed,
        "measures": {name: estimate(of_all).rounded() for name, of_all in values.items()},
        "ended": dict(Counter(one.ended for one in played)),
        "missed_deadlines": world.wait().missed_deadlines,
        "behavior": demo.behavior,
        "library_digest": open_library(library).digest,
        "seconds_of_episodes": values[SECONDS],
    }


def _watch(running: RunningSwarm) -> list[WorldState]:
    """Step through an episode and return the last moments."""
    world = running.world
    moments = [world.shown(world.control("reset"))]
    for _ in range(PICTURE_CYCLES):
        state = world.step()
        if state.episode_cycle == 0:
            break
        moments.append(state)
    return moments[-PICTURE_MOMENTS:]


def _keep_library(source: Path, destination: Path) -> None:
    for old in destination.glob("*.hfa.yaml"):
        old.unlink()
    copy_library(source, destination)


def _draw_automata(library: Path, names: Sequence[str], path: Path) -> None:
    from hitab_core import draw_automata

    loaded = open_library(library).load()
    draw_automata([loaded[name] for name in names if name in loaded], path)


def _draw_episode_lengths(evaluation: Mapping[str, Any], demo: Demo, path: Path) -> None:
    mean, _ = demo.references.get(SECONDS, (None, None))
    plots.draw_measures(
        {"length of the episode, s": {"ours": evaluation["seconds_of_episodes"]}},
        f"{demo.behavior}: {quantity(evaluation['episodes'], 'episode')}, seed "
        f"{evaluation['seed']}",
        path,
        {} if mean is None else {demo.reference: mean},
    )


def _row(report: LessonReport) -> dict[str, Any]:
    return {
        "automaton": report.lesson,
        "examples": report.examples,
        "default_examples": report.default_examples,
        "commands": report.commands,
        "training_s": report.simulated_s,
        "wall_s": report.wall_s,
        "checks": report.checks,
    }


def _show(
    reports: Sequence[LessonReport], figures: Mapping[str, Any], demo: Demo, out: Path
) -> None:
    console.out().print()
    reference = demo.reference
    _print_table(
        "What training took",
        ("automaton", "commands", "examples", f"examples, {reference}"),
        [(r.lesson, r.commands, r.examples, demo.examples.get(r.lesson, "")) for r in reports],
    )
    evaluation = figures["evaluation"]
    ended = ", ".join(f"{count} {how}" for how, count in sorted(evaluation["ended"].items()))
    against = f" against {demo.against}" if demo.against else ""
    _print_table(
        f"{quantity(evaluation['episodes'], 'episode')}{against}",
        ("", "ours", reference),
        [
            *(
                (name, _shown(mean["mean"], mean["se"]), _shown(*demo.references.get(name, ())))
                for name, mean in evaluation["measures"].items()
            ),
            ("ended", ended, ""),
            ("missed deadlines", evaluation["missed_deadlines"], ""),
        ],
    )
    library = shlex.quote(str(out / "library"))
    closing = f"; {demo.closing}" if demo.closing else ""
    console.out().print(
        f"\nAll of this took {figures['wall_s']:.0f} s. "
        f"The commands came from a script{closing}.\n"
        f"In {out}: field.png, automata.png, episode_lengths.png, figures.json, library/",
        soft_wrap=True,
    )
    hitab = called()
    following = {
        f"{hitab} library show {demo.behavior} --library {library}": "what was learned",
        f"{hitab} evaluate {demo.swarm} -l {library} -b {demo.behavior}": "play more",
        f"{hitab} up {demo.swarm}": "a world and agents to train yourself",
        f"{hitab} lesson list": "the lessons that trained these",
    }
    width = max(map(len, following))
    lines = (f"  {command:{width}}  # {what}" for command, what in following.items())
    console.say("\n".join(("\nNext:", *lines)))


def _shown(mean: float | None = None, error: float | None = None) -> str:
    if mean is None:
        return ""
    return f"{mean:.4g}" if error is None else f"{mean:.2f} ± {error:.2f}"


def _print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for column in columns:
        table.add_column(column, justify="left" if column == columns[0] else "right")
    for row in rows:
        table.add_row(*map(str, row))
    console.out().print(table)
