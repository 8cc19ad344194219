"""The scoreboard: what training by demonstration is worth beside other ways to the same team.

For each task, the team that the lessons train is compared with teams that have learned otherwise
from the same commands, with rules that nobody had to demonstrate, and with itself after something
has been taken away. All play the same episodes in one process.

    scripts/python research/learning.py --json learning.json
    scripts/python research/learning.py --task drill --task courier
    scripts/python research/learning.py --task drill --row rules --row random
    scripts/python research/learning.py --read learning.json

Rules and learners that have settings get those that score best in episodes of another seed than
that of the figures. Ctrl-C ends it; the JSON file then holds what is done.
"""

from __future__ import annotations

import json as js
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from math import sqrt
from pathlib import Path
from random import Random
from statistics import fmean, stdev
from typing import Annotated, Any

import typer
from foraging_tasks import Courier, Foraging
from peers import OPTIONS, TITLES, Learner, learn
from report import prefixed, progress
from soccer_tasks import Captain, Drill, Keepaway
from tasks import TRIED_SEED, Task, Team

TASKS: tuple[type[Task], ...] = (Keepaway, Captain, Foraging, Courier, Drill)
CHUNK = 5  # episodes between two reports of progress
QUICK_EPISODES, TRIES = 2, 30
CLONES = ("nearest", "tree", "mlp")

Say = Callable[[str], None]


@dataclass(frozen=True)
class Row:
    """A line of the scoreboard.

    Attributes:
        name, title: for programs and for people.
        commands, examples: that the team was trained with.
        mean, se: of its scores, and the standard error.
        relative: to the trained team's mean; None: that is 0.
        scores: of the episodes.
        setting: number of the setting that was chosen; 0 if there is only one.
    """

    name: str
    title: str
    commands: int
    examples: int
    mean: float
    se: float
    relative: float | None
    scores: tuple[float, ...]
    setting: int = 0


@dataclass(frozen=True)
class Entrant:
    """Teams of one kind, of which the best on tried episodes enters.

    Attributes:
        name, title: for programs and for people.
        teams: one for each setting.
        drawn: another team for each episode, by its number and the seed, instead.
    """

    name: str
    title: str
    teams: Sequence[Callable[[], Team]]
    drawn: Callable[[int, int], Team] | None = None


def entrants(task: Task) -> Iterator[Entrant]:
    """Return what is compared in a task, the trained team first."""
    yield Entrant("trained", "trained", [task.trained])
    yield Entrant(
        "rules", "the same words, one-line rules", [_given(team) for team in task.rules()]
    )
    yield Entrant(
        "random",
        "the same words, random thresholds",
        [_given(task.rules()[0])],
        lambda seed, episode: task.random_rules(Random(f"{seed} {episode}")),
    )
    if task.has_stop:
        yield Entrant("plain_stop", "a Stop that does nothing", [lambda: plain(task)])
    yield Entrant("no_defaults", "no default examples", [task.without_defaults])
    if task.name in ("captain", "foraging"):
        yield Entrant("no_commander", "no commander", [task.without_commander])
    kinds = ("flat", *CLONES) if task.has_levels else CLONES
    for name in kinds:
        yield Entrant(
            name,
            f"{TITLES[name]}, same commands",
            [_cloned(task, name, number) for number in range(len(OPTIONS[name]))],
        )
    for name in kinds:
        yield Entrant(
            f"{name}_corrected",
            f"{TITLES[name]}, corrected in play",
            [_corrected(task, name, number) for number in range(len(OPTIONS[name]))],
        )


def _given(team: Team) -> Callable[[], Team]:
    return lambda: team


def plain(task: Task) -> Team:
    """Return the trained team with a Stop that does nothing."""
    return replace(task.trained(), plain_stop=True)


def _cloned(task: Task, name: str, number: int) -> Callable[[], Team]:
    def make() -> Team:
        options = OPTIONS[name][number]
        policy = learn(name, task.commands, options=options, **task.peer_settings)
        return task.with_policy(policy, len(task.commands))

    return make


def _corrected(task: Task, name: str, number: int) -> Callable[[], Team]:
    def make() -> Team:
        settings = {"options": OPTIONS[name][number], **task.peer_settings}
        takeovers = task.corrected(Learner(name, settings), task.budget)
        assert takeovers.policy is not None, "the first cycle gives the first command"
        return task.with_policy(takeovers.policy, len(takeovers.commands))

    return make


def scores(task: Task, team: Team, episodes: int, seed: int, say: Say) -> list[float]:
    """Return a team's scores, and say how far it is."""
    found: list[float] = []
    while len(found) < episodes:
        say(f"{len(found)} of {episodes} episodes")
        count = min(CHUNK, episodes - len(found))
        found += task.play(team, count, seed, first=len(found))
    return found


def row_of(
    task: Task, entrant: Entrant, episodes: int, seed: int, base: float | None, say: Say
) -> Row:
    """Return a row: choose the setting, then play.

    Args:
        task: that is played.
        entrant: who plays.
        episodes, seed: of the figure.
        base: mean of the trained team; None: this is it.
        say: called with what is going on.
    """
    teams = [make() for make in entrant.teams]
    chosen = 0
    if len(teams) > 1:
        tries = max(1, min(TRIES, episodes // 4))
        tried = [
            fmean(scores(task, team, tries, TRIED_SEED, prefixed(say, f"setting {i + 1}: ")))
            for i, team in enumerate(teams)
        ]
        chosen = max(range(len(teams)), key=lambda i: tried[i])
    team = teams[chosen]
    found: list[float] = []
    if entrant.drawn is None:
        found = scores(task, team, episodes, seed, say)
    else:
        for episode in range(episodes):
            found += task.play(entrant.drawn(seed, episode), 1, seed, first=episode)
    mean = fmean(found)
    return Row(
        entrant.name,
        entrant.title,
        team.commands,
        team.examples,
        mean,
        stdev(found) / sqrt(len(found)) if len(found) > 1 else 0.0,
        1.0 if base is None else mean / base if base else None,
        tuple(found),
        chosen,
    )


def table(title: str, measure: str, rows: Sequence[dict[str, Any]]) -> str:
    """Return rows as a table in Markdown."""
    lines = [
        f"| {title} | commands | examples | {measure} | of the trained |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    lines += [
        f"| {row['title']} | {row['commands']} | {row['examples']} "
        f"| {row['mean']:.2f} ± {row['se']:.2f} | {_percent(row['relative'])} |"
        for row in rows
    ]
    return "\n".join(lines)


def _percent(ratio: float | None) -> str:
    return "" if ratio is None else f"{ratio:.0%}"


def tell(figures: dict[str, Any]) -> None:
    """Print all tables."""
    for found in figures["tasks"].values():
        print(f"\n{found['episodes']} episodes, seed {figures['seed']}:\n")
        print(table(found["title"], found["measure"], found["rows"]), flush=True)


def main(
    tasks: Annotated[
        list[str] | None,
        typer.Option("--task", help="Task to play; repeat for several. All by default."),
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option("--row", help="Row to play beside the trained; repeat for several."),
    ] = None,
    episodes: Annotated[
        int,
        typer.Option("--episodes", help="Episodes of each row; 0: the task's own number.", min=0),
    ] = 0,
    seed: Annotated[int, typer.Option(help="Seed of the episodes.")] = 2026,
    quick: Annotated[
        bool, typer.Option("--quick", help="Two short episodes: whether it works, no figures.")
    ] = False,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    read: Annotated[str, typer.Option("--read", help="Play nothing; read this JSON file.")] = "",
) -> None:
    """Compare ways to learn from the same commands."""
    if read:
        tell(js.loads(Path(read).read_text(encoding="utf-8")))
        return
    known = {made.name: made for made in TASKS}
    unknown = sorted({*(tasks or ())} - {*known})
    if unknown:
        raise typer.BadParameter(f"no task {', '.join(unknown)} (known: {', '.join(known)})")
    if seed == TRIED_SEED:
        raise typer.BadParameter(f"seed {seed} is that of tried episodes; take another one")
    figures: dict[str, Any] = {"seed": seed, "tasks": {}}
    try:
        for name in tasks or known:
            task = known[name](quick=quick)
            count = QUICK_EPISODES if quick else episodes or task.episodes
            rows: list[dict[str, Any]] = []
            figures["tasks"][name] = {
                "title": task.title,
                "measure": task.measure,
                "episodes": count,
                "rows": rows,
            }
            for entrant in entrants(task):
                if only and entrant.name not in ("trained", *only):
                    continue
                label = f"{name}, {entrant.title}: "
                base = rows[0]["mean"] if rows else None
                if quick:
                    entrant = replace(entrant, teams=entrant.teams[:1])
                row = row_of(task, entrant, count, seed, base, prefixed(progress, label))
                rows.append(asdict(row))
                progress("")
                print(
                    f"{label}{row.mean:.2f} ± {row.se:.2f} "
                    f"({row.commands} commands, {row.examples} examples)",
                    file=sys.stderr,
                    flush=True,
                )
                if json:
                    text = js.dumps(figures, indent=1) + "\n"
                    Path(json).write_text(text, encoding="utf-8")
    except KeyboardInterrupt:
        print("\ninterrupted; this is what was done until then", file=sys.stderr)
    tell(figures)


if __name__ == "__main__":
    typer.run(main)
