"""Verbs for lessons: run, list, check."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_cli.verbs.verb_connection import connection
from hitab_client import LessonError, completion, console
from hitab_client.runs.shipped import find_file, shipped_folders
from hitab_client.terminal.cli_options import JsonPath, SwarmName
from hitab_client.terminal.cli_remedies import with_commands
from hitab_core import Fix, HitabError, Remedy, quantity

if TYPE_CHECKING:
    from hitab_client.lessons import LessonPlayer, LessonReport

app = typer.Typer(help="Play lessons: files that teach like a person, over the same topics.")


@app.command()
def run(
    lessons: Annotated[list[str], typer.Argument(autocompletion=completion.lessons)],
    factor: float = 0.0,
    discard: Annotated[bool, typer.Option("--discard")] = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Play lessons on the swarm that is up.

    Ctrl-C ends the lesson and discards its unsaved training. If a step fails, the training stays,
    so that you can inspect and correct it.

    Args:
        lessons: Lesson files, or names of shipped ones, in order.
        factor: Multiple of real time, for watching; 0 for full speed.
        discard: First discard the agents' unsaved trainings.

    Examples:
      hitab lesson run approach_ball
      hitab lesson run approach_ball goto_ball --json lessons.json
    """
    from hitab_client.lessons import LessonPlayer, read_lesson

    read = [read_lesson(find_file(name, "lessons", "lesson")) for name in lessons]
    reports = []
    with connection(swarm) as swarm_up:
        swarm_up.agents.await_agents()
        world = swarm_up.await_world()
        for lesson in read:
            player = LessonPlayer(lesson, swarm_up.agents, world, factor=factor, discard=discard)
            report = _played(player)
            reports.append(report)
            budget = f" of at most {report.budget}" if report.budget else ""
            console.say(
                f"{report.lesson}: {quantity(report.examples, 'example')}{budget} "
                f"({report.default_examples} default), {quantity(report.commands, 'command')}, "
                f"{report.simulated_s:.1f} s of training in {report.wall_s:.1f} s"
            )
            if report.note:
                console.say(f"    {report.note}")
    console.write_json(json, [asdict(report) for report in reports])


def _played(player: LessonPlayer) -> LessonReport:
    """Play a lesson; report its unsaved trainings, or on Ctrl-C discard them."""
    try:
        with console.progress(player.lesson.name, "steps") as advance:
            report = player.play(advance)
    except HitabError as error:
        raise LessonError(error.problem, *error.remedies, *_left(player)) from None
    except (KeyboardInterrupt, SystemExit):
        taken_back = player.take_back()
        for done in taken_back:
            console.note(done)
        if not taken_back:
            console.note(
                f"{player.lesson.name} leaves nothing in training; what was saved stays, and the "
                "agents go on with what they did"
            )
        raise
    for agent, automaton in player.begun.items():
        text = f'{agent} is still training "{automaton}"; go on by hand and save it'
        console.note(with_commands(text, [Fix.DISCARD(agent=agent)]))
    return report


def _left(player: LessonPlayer) -> list[Remedy]:
    """Return the remedies that end the trainings that a lesson has left."""
    return [do(agent=agent) for agent in player.begun for do in (Fix.SAVE, Fix.DISCARD)]


@app.command("list")
def list_lessons() -> None:
    """List the shipped lessons."""
    from hitab_client.lessons import read_lesson

    found = [
        (path, place) for place in shipped_folders("lessons") for path in place.rglob("*.yaml")
    ]
    for path, folder in sorted(found):
        lesson = read_lesson(path)
        budget = f", at most {quantity(lesson.budget, 'example')}" if lesson.budget else ""
        first = lesson.description.strip().splitlines()[:1]
        name = path.relative_to(folder).with_suffix("").as_posix()
        console.say(f"{name}: teaches {lesson.name} to {lesson.agent}{budget}")
        for line in first:
            console.say(f"    {line}")


@app.command()
def check(files: Annotated[list[Path], typer.Argument(metavar="LESSON...")]) -> None:
    """Check lesson files without playing them.

    Args:
        files: Lesson files, or names of shipped lessons.

    Example:
      hitab lesson check my_lesson.yaml
    """
    from hitab_client.lessons import read_lesson

    wrong = []
    for given in files:
        path = find_file(str(given), "lessons", "lesson")
        try:
            lesson = read_lesson(path)
        except LessonError as error:
            wrong.append(str(error))
        else:
            console.say(f"{path}: {quantity(len(lesson.steps), 'step')}, nothing is wrong")
    if wrong:
        raise LessonError("\n".join(wrong))
