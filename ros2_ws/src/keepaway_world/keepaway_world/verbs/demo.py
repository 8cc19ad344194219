"""The demo: train three keepers over ROS topics, play, and compare with the paper."""

from __future__ import annotations

import contextlib
import json
import shlex
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hitab_bringup import RunningSwarm, copy_library, open_library, temporary_swarm
from hitab_client import console
from hitab_client.commands import called
from hitab_client.lessons import LessonPlayer, LessonReport, read_lesson
from hitab_client.shipped import find_file
from hitab_core import HitabError
from keepaway_world.verbs import paper
from keepaway_world.verbs.demo_studio import play_on, studio_beside
from keepaway_world.verbs.evaluation import (
    Evaluation,
    draw_episode_lengths,
    play_lockstep,
    trained_keepers,
)
from keepaway_world.verbs.field_picture import draw_field

LESSONS = ("approach_ball", "goto_ball", "control_ball", "keepaway")
TEACHER = "keeper_1"
PICTURE_CYCLES = 120
LINE_EVERY = 20
"""Episodes after which a line says how far it is, where there is no progress bar."""
PICTURE_TITLE = "Keepaway: keepers blue, takers red, and the ways of the last seconds"


def run_demo(
    out: Path,
    episodes: int,
    seed: int,
    studio_port: int | None = None,
    *,
    browser: bool = True,
) -> dict[str, Any]:
    """Train, play, compare, and write everything to a folder.

    Args:
        out: the folder; pictures, figures and the library of an earlier demo are replaced.
        episodes: number to play.
        seed: of the episodes.
        studio_port: of the studio during the demo; None: no studio.
        browser: whether to open the studio in a browser.

    Returns:
        The figures, as written to ``figures.json``.
    """
    began = time.monotonic()
    _make_folder(out)
    parameters = {"taker_speed": paper.TAKER_SPEED}
    with contextlib.ExitStack() as stack:
        stack.callback(_remove_if_empty, out)
        with console.progress("starting a world and three keepers") as advance:
            running = stack.enter_context(
                temporary_swarm(trained_keepers(None, "", parameters), progress=advance)
            )
        console.say("A world and three keepers are up, each in its own process.\n")
        if studio_port is not None:
            stack.enter_context(studio_beside(running, studio_port, browser=browser))
        reports = _train(running)
        library = Path(reports[-1].path).parent
        evaluation = _evaluate(running, library, episodes, seed, parameters)
        moments, size = _watch(running)
        _keep_library(library, out / "library")
        # With the studio, the swarm stays up after the report.
        staying = contextlib.ExitStack() if studio_port is None else stack.pop_all()
    with staying:
        figures = {
            "lessons": [_row(report) for report in reports],
            "evaluation": evaluation.to_json(),
            "wall_s": round(time.monotonic() - began, 1),
        }
        draw_episode_lengths(evaluation, out / "episode_lengths.png")
        draw_field(moments, *size, out / "field.png", PICTURE_TITLE)
        _draw_automata(out / "library", out / "automata.png")
        (out / "figures.json").write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
        _tell(reports, figures, out)
        if studio_port is not None:
            play_on(running)
    return figures


def _make_folder(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HitabError(
            f"{out} cannot be made ({error.strerror}); choose another folder with --out"
        ) from None


def _remove_if_empty(out: Path) -> None:
    """Remove the folder if the demo was interrupted before it wrote anything."""
    with contextlib.suppress(OSError):
        out.rmdir()


def _train(running: RunningSwarm) -> list[LessonReport]:
    reports = []
    for name in LESSONS:
        lesson = read_lesson(find_file(name, "lessons", "lesson"))
        with console.progress(f"teaching {lesson.name}", "steps") as advance:
            report = LessonPlayer(lesson, running.agents, running.world).play(advance)
        reports.append(report)
        console.say(
            f"Taught {report.lesson}: {report.examples} examples from {report.commands} commands"
        )
    return reports


def _evaluate(
    running: RunningSwarm, library: Path, episodes: int, seed: int, parameters: dict[str, Any]
) -> Evaluation:
    for agent in running.record.agents:
        running.agents.perform(agent, "Keepaway")
    with console.progress("playing", "episodes", line_every=LINE_EVERY) as advance:
        played, wall, missed = play_lockstep(running, episodes, seed, advance)
    digest = open_library(library).digest
    return Evaluation(
        "Keepaway", "library", digest, "lockstep", seed, parameters, played, wall, missed
    )


def _watch(running: RunningSwarm) -> tuple[list[Sequence[Any]], tuple[float, float]]:
    """Step through an episode and return the states of its last seconds."""
    world = running.world
    state = world.shown(world.control("reset"))
    moments = [state.entities]
    for _ in range(PICTURE_CYCLES):
        state = world.step()
        if state.episode_cycle == 0:
            break
        moments.append(state.entities)
    return moments[-80:], (state.width, state.height)


def _keep_library(source: Path, destination: Path) -> None:
    for old in destination.glob("*.hfa.yaml"):
        old.unlink()
    copy_library(source, destination)


def _draw_automata(library: Path, path: Path) -> None:
    from hitab_core import draw_automata

    loaded = open_library(library).load()
    draw_automata([loaded[name] for name in paper.TABLE_1 if name in loaded], path)


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


def _tell(reports: list[LessonReport], figures: dict[str, Any], out: Path) -> None:
    screen = console.out()
    screen.print()
    _print_table(
        "What training took (the paper's Table 1)",
        ("automaton", "commands", "examples", "examples in the paper"),
        [(r.lesson, r.commands, r.examples, paper.TABLE_1[r.lesson].examples) for r in reports],
    )
    evaluation = figures["evaluation"]
    hold, passes, ended = (evaluation[key] for key in ("hold_time_s", "passes", "ended"))
    _print_table(
        f"{evaluation['episodes']} episodes against takers at a quarter of their speed",
        ("", "ours", "paper"),
        [
            (
                "hold time",
                f"{hold['mean']:.2f} ± {hold['se']:.2f} s",
                f"{paper.HOLD_TIME_S} ± {paper.HOLD_TIME_SE_S} s",
            ),
            ("passes", f"{passes['mean']:.2f} ± {passes['se']:.2f}", paper.PASSES),
            ("ended", ", ".join(f"{count} {how}" for how, count in ended.items()), ""),
            ("missed deadlines", evaluation["missed_deadlines"], ""),
        ],
    )
    library = shlex.quote(str(out / "library"))
    minutes = sum(row.minutes for row in paper.TABLE_1.values())
    screen.print(
        f"\nAll of this took {figures['wall_s']:.0f} s. The commands came from a script; the "
        f"paper's demonstrators took {minutes} minutes.\n"
        f"In {out}: field.png, automata.png, episode_lengths.png, figures.json, library/",
        soft_wrap=True,
    )
    hitab = called()
    following = {
        f"{hitab} library show Keepaway --library {library}": "what was learned",
        f"{hitab} keepaway evaluate --library {library}": "play more",
        f"{hitab} up keepaway": "a world and three keepers to train yourself",
        f"{hitab} lesson list": "the lessons that trained these",
    }
    width = max(map(len, following))
    lines = (f"  {command:{width}}  # {what}" for command, what in following.items())
    console.say("\n".join(("\nNext:", *lines)))


def _print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for column in columns:
        table.add_column(column, justify="left" if column == columns[0] else "right")
    for row in rows:
        table.add_row(*map(str, row))
    console.out().print(table)
