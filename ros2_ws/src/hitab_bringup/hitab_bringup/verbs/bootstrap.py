"""Verbs of behavior bootstrapping: next, back, list."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_bringup.verbs.connection import connection
from hitab_client import SwarmError, console
from hitab_client.cli_options import AgentName, JsonPath, SwarmName
from hitab_core import Fix, has

if TYPE_CHECKING:
    from hitab_client import RunFolder
    from hitab_client.bootstrapping import Bootstrapping, Configuration, Generation, Generations

app = typer.Typer(
    help="Train a team step by step: one agent learns among teammates that perform what it has "
    "learned so far. Use it if the right behavior depends on what the others do.",
)

TO = "A teammate. Repeatable. Default: all others of the agent's domain."
SNAPSHOT = "Restore this snapshot afterwards, and train on from there."
PLACE = "Place things as this file says afterwards, and train on from there."
WAIT = 'Let the agent act afterwards until this holds, such as "{said: keeper_2}".'
To = Annotated[list[str] | None, typer.Option("--to", help=TO)]
Episodes = Annotated[int, typer.Option(help="Episodes to play for the score; 0: no score.", min=0)]
Seed = Annotated[int, typer.Option(help="Seed of these episodes.", min=0)]
SnapshotName = Annotated[str, typer.Option(metavar="NAME", help=SNAPSHOT, show_default=False)]
PlaceFile = Annotated[Path | None, typer.Option(metavar="FILE", help=PLACE)]
WaitFor = Annotated[str, typer.Option(metavar="CONDITION", help=WAIT, show_default=False)]
Within = Annotated[float | None, typer.Option(help="Give up waiting after so many seconds.")]
AsItIs = Annotated[bool, typer.Option("--as-it-is", help="Train on in the world as it is.")]


@app.command("next")
def next_(
    agent: AgentName,
    to: To = None,
    episodes: Episodes = 20,
    seed: Seed = 1,
    note: str = "",
    snapshot: SnapshotName = "",
    place: PlaceFile = None,
    wait: WaitFor = "",
    within: Within = None,
    as_it_is: AsItIs = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Make the next generation: save the behavior in training, and train on among the teammates.

    The teammates get it and perform it from Start, and it is evaluated. The training goes on with
    the examples so far. Without --snapshot, --place or --wait it goes on as after the last
    generation.

    Args:
        note: To keep with the generation.

    Examples:
      hitab bootstrap next keeper_1 --note "the closest one takes the ball"
      hitab bootstrap next keeper_1 --wait "{said: keeper_2}" --within 20
    """
    from hitab_client.bootstrapping import Evaluation

    chosen = _configuration(agent, snapshot, place, wait, within, as_it_is)
    with _steps(swarm, json) as steps:
        evaluation = Evaluation(episodes, seed)
        made = steps.next(
            agent, to=to or (), note=note, evaluation=evaluation, configuration=chosen
        )
    _show_made(json, agent, made)


@app.command()
def back(
    agent: AgentName,
    behavior: str,
    generation: int,
    to: To = None,
    discard: Annotated[bool, typer.Option("--discard")] = False,
    episodes: Episodes = 20,
    seed: Seed = 1,
    snapshot: SnapshotName = "",
    place: PlaceFile = None,
    wait: WaitFor = "",
    within: Within = None,
    as_it_is: AsItIs = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Go back to a generation: the team performs it again, and the training goes on from it.

    It becomes the next version in the libraries; the later generations are kept. If it has no
    score, it is evaluated.

    Args:
        behavior: The behavior that is bootstrapped.
        generation: Its number; see `hitab bootstrap list`.
        discard: Give up examples that are in no generation.

    Example:
      hitab bootstrap back keeper_1 Keepaway 2
    """
    from hitab_client.bootstrapping import Evaluation

    chosen = _configuration(agent, snapshot, place, wait, within, as_it_is)
    with _steps(swarm, json) as steps:
        made = steps.back(
            agent,
            behavior,
            generation,
            to=to or (),
            discard=discard,
            evaluation=Evaluation(episodes, seed),
            configuration=chosen,
        )
    _show_made(json, agent, made)


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
    from hitab_client.bootstrapping import behaviors_in, folder_of, read_generations
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant

    found = find_meant(swarm, chosen_by_user())
    folder = folder_of(_kept_in(found[0] if found else None), agent)
    there = behaviors_in(folder)
    if not there or (behavior and behavior not in there):
        what = f"{behavior} of {agent}" if behavior else agent
        raise SwarmError(
            f"{what} has no generations {has(there, behavior)}", Fix.NEXT_GENERATION(agent=agent)
        )
    read = [read_generations(folder, agent, name) for name in ([behavior] if behavior else there)]
    shown = [part for known in read for part in _shown(known, by, least)]
    console.show(json, [_plain(known, by, least) for known in read], *shown)


def _shown(known: Generations, by: str, least: bool) -> Iterator[Any]:
    """Yield what is shown of the generations of a behavior."""
    figures = {name for g in known.all if g.score is not None for name in g.score.figures}
    if figures and by not in figures:
        raise SwarmError(f'no generation has a figure "{by}" {has(figures, by)}')
    best = known.best(by, least=least)
    rows = [
        (
            f"{g.number}{' *' if best is not None and g.number == best.number else ''}",
            str(g.parent or ""),
            ", ".join(map(str, (g.version, *g.restored))),
            str(g.score.figures.get(by, "")) if g.score else f"none: {g.unscored}",
            f"{g.score.episodes}, seed {g.score.seed}" if g.score else "",
            str(g.examples),
            g.at.replace("T", " ").removesuffix("Z")[:16],
            g.by,
            g.digest[:8],
            g.note,
        )
        for g in known.all
    ]
    columns = ("generation", "from", "version", by, "episodes", "examples", "when (UTC)", "who")
    title = (
        f"{known.behavior}, trained on {known.agent}; it goes on from generation {known.current}"
    )
    yield console.table((*columns, "file", "note"), rows, title)
    if best is not None:
        yield f"* the best by {by}, of those evaluated alike"


def _plain(known: Generations, by: str, least: bool) -> dict[str, Any]:
    from hitab_client.bootstrapping import record_of

    best = known.best(by, least=least)
    return {
        "agent": known.agent,
        "behavior": known.behavior,
        "current": known.current,
        "best": None if best is None else best.number,
        "generations": [record_of(g) for g in known.all],
    }


def _show_made(json: str | None, agent: str, made: Generation) -> None:
    from hitab_client.bootstrapping import record_of

    told = f"{agent} is in training mode, with generation {made.number}"
    console.show(json, [record_of(made)], told)


def _configuration(
    agent: str, snapshot: str, place: Path | None, wait: str, within: float | None, as_it_is: bool
) -> Configuration | None:
    """Return what the options name; None: nothing."""
    from hitab_client.bootstrapping import Configuration, read_configuration, with_condition

    if (as_it_is and (snapshot or place or wait)) or (snapshot and place):
        raise typer.BadParameter("give one of --as-it-is, --snapshot, --place and --wait")
    if within is not None and not (within > 0.0 and (wait or place)):
        raise typer.BadParameter("--within needs a number above 0, and --wait or --place")
    if not (as_it_is or snapshot or place or wait):
        return None
    chosen = read_configuration(place, agent) if place else Configuration(snapshot=snapshot)
    if wait:
        chosen = with_condition(chosen, wait, agent)
    return chosen if within is None else chosen.but(within=within)


@contextmanager
def _steps(swarm: str | None, json: str | None) -> Iterator[Bootstrapping]:
    """Yield what does the steps; say what an interruption leaves to be done."""
    from hitab_client.bootstrapping import Bootstrapping

    say = console.note if json == "-" else console.say
    with connection(swarm) as swarm_up:
        world, folder = swarm_up.await_world(), _kept_in(swarm_up.folder)
        try:
            with console.progress("bootstrapping") as progress:
                steps = Bootstrapping(swarm_up.agents, world, folder, say=say, progress=progress)
                yield steps
        except (KeyboardInterrupt, SystemExit):
            console.note(steps.left or "nothing has changed")
            raise


def _kept_in(folder: RunFolder | None) -> Path:
    """Return the folder that keeps the generations; one for all robots started by hand."""
    from hitab_client.run_folder import state_home

    return state_home() if folder is None else folder.path
