"""Verbs of behavior bootstrapping: next, back, list."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_cli.verbs.verb_connection import connection
from hitab_client import SwarmError, console
from hitab_client.cli_options import AgentName, JsonPath, SwarmName
from hitab_core import Fix, has

if TYPE_CHECKING:
    from hitab_client import RunFolder
    from hitab_client.bootstrapping import Generations

app = typer.Typer(
    help="Train a team step by step: one agent learns among teammates that perform what it has "
    "learned so far. Use it if the right behavior depends on what the others do."
)

WAIT = 'Let the agent act afterwards until this holds, such as "{said: keeper_2}".'
WITHIN = "Give up waiting after so many s. Default: never."
To = Annotated[
    list[str] | None,
    typer.Option(help="A teammate. Repeatable. Default: all others of the agent's domain."),
]
Episodes = Annotated[int, typer.Option(help="Episodes to play for the score; 0: no score.", min=0)]
Seed = Annotated[int, typer.Option(help="Seed of these episodes.", min=0)]
Wait = Annotated[str, typer.Option(metavar="CONDITION", help=WAIT, show_default=False)]
Within = Annotated[float, typer.Option(help=WITHIN, min=0.0, show_default=False)]


@app.command("next")
def next_(
    agent: AgentName,
    to: To = None,
    episodes: Episodes = 20,
    seed: Seed = 1,
    note: str = "",
    wait: Wait = "",
    within: Within = float("inf"),
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Make the next generation: save the behavior in training, and train on among the teammates.

    The teammates get it and perform it from Start, and it is evaluated. The training goes on with
    the examples so far, in the world as it was. A generation has the number of its version in the
    agent's library.

    Args:
        note: To keep with the generation.

    Examples:
      hitab bootstrap next keeper_1 --note "the closest one takes the ball"
      hitab bootstrap next keeper_1 --wait "{said: keeper_2}" --within 20
    """
    options = {"to": to or (), "episodes": episodes, "seed": seed, "wait": wait, "within": within}
    _make(swarm, json, options, "next", agent, note)


@app.command()
def back(
    agent: AgentName,
    behavior: str,
    generation: Annotated[int, typer.Argument(min=1)],
    discard: Annotated[bool, typer.Option("--discard")] = False,
    to: To = None,
    episodes: Episodes = 20,
    seed: Seed = 1,
    wait: Wait = "",
    within: Within = float("inf"),
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Go back to a generation: it is the next one, too, and the training goes on from it.

    What it uses stays as it is now.

    Args:
        behavior: The behavior that is bootstrapped.
        generation: Its number; see `hitab bootstrap list`. Any version in the library will do.
        discard: Give up examples that are in no generation.

    Example:
      hitab bootstrap back keeper_1 Keepaway 2
    """
    options = {"to": to or (), "episodes": episodes, "seed": seed, "wait": wait, "within": within}
    _make(swarm, json, options, "back", agent, behavior, generation, discard)


@app.command("list")
def list_(
    agent: AgentName,
    behavior: Annotated[str, typer.Argument()] = "",
    by: str = "seconds",
    least: Annotated[bool, typer.Option("--least")] = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """List the generations of an agent's behaviors, with their scores; the best is marked.

    The score is the mean of a figure in a few episodes, with its standard error: of the length of
    an episode, or of what else the world reports.

    Args:
        behavior: A behavior. Default: all.
        by: The figure that counts, such as passes.
        least: Lower is better.

    Examples:
      hitab bootstrap list keeper_1
      hitab bootstrap list keeper_1 Keepaway --by passes
    """
    from hitab_client.bootstrapping import folder_of, read_generations
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant

    found = find_meant(swarm, chosen_by_user())
    folder = folder_of(_kept_in(found[0] if found else None), agent)
    there = sorted(path.stem for path in folder.glob("*.yaml"))
    if not there or (behavior and behavior not in there):
        what = f"{behavior} of {agent}" if behavior else agent
        raise SwarmError(
            f"{what} has no generations {has(there, behavior)}", Fix.NEXT_GENERATION(agent=agent)
        )
    known = {name: read_generations(folder, name) for name in ([behavior] if behavior else there)}
    best = {name: all_.best(by, least=least) for name, all_ in known.items()}
    plain = [
        {"agent": agent, "behavior": name, "best": best[name], **all_.model_dump(by_alias=True)}
        for name, all_ in known.items()
    ]
    shown = [_table(agent, name, all_, by, best[name]) for name, all_ in known.items()]
    ending = [f"* the best by {by}, of those evaluated alike"] * any(best.values())
    console.show(json, plain, *shown, *ending)


def _table(agent: str, behavior: str, known: Generations, by: str, best: int) -> Any:
    figures = {name for g in known.all for name in g.score.figures}
    if figures and by not in figures:
        raise SwarmError(f'no generation has a figure "{by}" {has(figures, by)}')
    rows = [
        (
            f"{g.version}{' *' * (g.version == best)}",
            str(g.score.figures.get(by, "")) or f"none: {g.unscored}",
            f"{g.score.episodes}, seed {g.score.seed}" if g.score.episodes else "",
            str(g.examples),
            g.at.replace("T", " ")[:16],
            g.by,
            g.note,
        )
        for g in known.all
    ]
    columns = ("generation", by, "episodes", "examples", "when (UTC)", "who", "note")
    return console.table(columns, rows, f"{behavior}, trained on {agent}")


def _make(
    swarm: str | None,
    json: str | None,
    options: dict[str, Any],
    step: str,
    agent: str,
    *given: Any,
) -> None:
    """Make a generation by a step of bootstrapping; say what an interruption leaves to be done."""
    from hitab_client.bootstrapping import Bootstrapping

    options["say"] = console.note if json == "-" else console.say
    with connection(swarm) as there, console.progress("bootstrapping") as progress:
        options["progress"], folder = progress, _kept_in(there.folder)
        steps = Bootstrapping(there.agents, there.await_world(), folder, **options)
        try:
            generation = getattr(steps, step)(agent, *given)
        except (KeyboardInterrupt, SystemExit):
            console.note(steps.left or "nothing has changed")
            raise
    told = f"{agent} is in training mode, with generation {generation.version}"
    console.show(json, [generation.model_dump()], told)


def _kept_in(folder: RunFolder | None) -> Path:
    """Return the folder that keeps the generations; one for all robots started by hand."""
    from hitab_client.run_folder import state_home

    return state_home() if folder is None else folder.path
