"""Verbs of behavior bootstrapping: next, back, list."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

import typer

from hitab_bringup.help_pages import HelpfulGroup
from hitab_bringup.verbs.connection import Connection, connection
from hitab_client import console
from hitab_client.command_options import AgentName, JsonPath, SwarmName
from hitab_core import Do

if TYPE_CHECKING:
    from hitab_client.bootstrapping import Bootstrapping, Configuration, Generation, Generations

app = typer.Typer(
    help="Train a team step by step: one agent learns among teammates that perform what it has "
    "learned so far. Use it if the right behavior depends on what the others do.",
)

To = Annotated[
    list[str] | None,
    typer.Option(
        "--to", help="A teammate. Repeatable. Default: all others of the agent's domain."
    ),
]
Episodes = Annotated[int, typer.Option(help="Episodes to play for the score; 0: no score.", min=0)]
Seed = Annotated[int, typer.Option(help="Seed of these episodes.", min=0)]
SnapshotName = Annotated[
    str,
    typer.Option(
        "--snapshot",
        metavar="NAME",
        help="Restore this snapshot afterwards, and train on from there.",
        show_default=False,
    ),
]
PlaceFile = Annotated[
    Path | None,
    typer.Option(
        "--place",
        metavar="FILE",
        help="Place things as this file says afterwards, and train on from there.",
        show_default=False,
    ),
]
WaitFor = Annotated[
    str,
    typer.Option(
        "--wait",
        metavar="CONDITION",
        help='Let the agent act afterwards until this holds, such as "{said: keeper_2}".',
        show_default=False,
    ),
]
Within = Annotated[
    float | None,
    typer.Option(help="Give up waiting after so many seconds.", show_default=False),
]
AsItIs = Annotated[bool, typer.Option("--as-it-is", help="Train on in the world as it is.")]
By = Annotated[str, typer.Option(help="The figure that counts, such as passes.")]
Least = Annotated[bool, typer.Option("--least", help="Lower is better.")]


def register(main: typer.Typer) -> None:
    """Add this group to the command."""
    main.add_typer(app, name="bootstrap", cls=HelpfulGroup, rich_help_panel="Train")


@app.command("next")
def next_(
    agent: AgentName,
    to: To = None,
    episodes: Episodes = 20,
    seed: Seed = 1,
    note: Annotated[str, typer.Option(help="To keep with the generation.")] = "",
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

    Examples:

      hitab bootstrap next keeper_1 --note "the closest one takes the ball"

      hitab bootstrap next keeper_1 --wait "{said: keeper_2}" --within 20
    """
    from hitab_client.bootstrapping import Evaluation

    chosen = _configuration(agent, snapshot, place, wait, within, as_it_is)
    with connection(swarm) as swarm_up, _steps(swarm_up, json) as steps:
        made = steps.next(
            agent,
            to=to or (),
            note=note,
            evaluation=Evaluation(episodes, seed),
            configuration=chosen,
        )
    if json != "-":
        console.say(f"{agent} is in training mode, with generation {made.number}")
    _write(json, [made])


@app.command()
def back(
    agent: AgentName,
    behavior: Annotated[str, typer.Argument(help="The behavior that is bootstrapped.")],
    generation: Annotated[int, typer.Argument(help="Its number; see `hitab bootstrap list`.")],
    to: To = None,
    discard: Annotated[
        bool, typer.Option("--discard", help="Give up examples that are in no generation.")
    ] = False,
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

    Example:

      hitab bootstrap back keeper_1 Keepaway 2
    """
    from hitab_client.bootstrapping import Evaluation

    chosen = _configuration(agent, snapshot, place, wait, within, as_it_is)
    with connection(swarm) as swarm_up, _steps(swarm_up, json) as steps:
        made = steps.back(
            agent,
            behavior,
            generation,
            to=to or (),
            discard=discard,
            evaluation=Evaluation(episodes, seed),
            configuration=chosen,
        )
    if json != "-":
        console.say(f"{agent} is in training mode, with generation {made.number}")
    _write(json, [made])


@app.command("list")
def list_(
    agent: AgentName,
    behavior: Annotated[str, typer.Argument(help="A behavior. Default: all.")] = "",
    by: By = "seconds",
    least: Least = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """List the generations of an agent's behaviors, with their scores; the best is marked.

    The score is the mean of a figure in a few episodes, with its standard error: of the length of
    an episode, or of what else the world reports.

    Examples:

      hitab bootstrap list keeper_1

      hitab bootstrap list keeper_1 Keepaway --by passes
    """
    from hitab_client import SwarmError
    from hitab_client.bootstrapping import behaviors_in, folder_of, read_generations
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.swarm_choice import find_meant
    from hitab_core import has

    found = find_meant(swarm, chosen_by_user())
    folder = folder_of(_kept_in(found[0] if found else None), agent)
    there = behaviors_in(folder)
    if not there or (behavior and behavior not in there):
        what = f"{behavior} of {agent}" if behavior else agent
        raise SwarmError(
            f"{what} has no generations {has(there, behavior)}", Do.NEXT_GENERATION(agent=agent)
        )
    read = [read_generations(folder, agent, name) for name in ([behavior] if behavior else there)]
    if json != "-":
        for known in read:
            _show(known, by, least)
    _write(json, read, by, least)


def _show(known: Generations, by: str, least: bool) -> None:
    from hitab_client import SwarmError
    from hitab_core import has

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
    console.out().print(console.table((*columns, "file", "note"), rows, title))
    if best is not None:
        console.say(f"* the best by {by}, of those evaluated alike")


def _configuration(
    agent: str, snapshot: str, place: Path | None, wait: str, within: float | None, as_it_is: bool
) -> Configuration | None:
    """Return what the options name; None: nothing."""
    from hitab_client.bootstrapping import Configuration, read_configuration, with_condition

    named = any((snapshot, place, wait))
    if as_it_is and named:
        raise typer.BadParameter(
            "--as-it-is cannot be combined with --snapshot, --place or --wait"
        )
    if snapshot and place:
        raise typer.BadParameter("give --snapshot or --place, not both")
    if within is not None and not within > 0.0:
        raise typer.BadParameter("--within needs a number of seconds above 0")
    if not named:
        if within is not None:
            raise typer.BadParameter("--within needs --wait or --place")
        return Configuration() if as_it_is else None
    chosen = read_configuration(place, agent) if place else Configuration(snapshot=snapshot)
    if wait:
        chosen = with_condition(chosen, wait, agent)
    return chosen if within is None else replace(chosen, within=within)


@contextmanager
def _steps(swarm_up: Connection, json: str | None) -> Iterator[Bootstrapping]:
    """Yield what does the steps; say what an interruption leaves to be done."""
    from hitab_client.bootstrapping import Bootstrapping

    with _Showing(console.note if json == "-" else console.say) as showing:
        steps = Bootstrapping(
            swarm_up.agents,
            _world(swarm_up),
            _kept_in(swarm_up.folder),
            say=showing.say,
            progress=showing.progress,
        )
        try:
            yield steps
        except (KeyboardInterrupt, SystemExit):
            showing.close()
            console.note(steps.left or "nothing has changed")
            raise


class _Showing:
    """Prints what is done, and between two such lines a progress bar; a context manager."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._bar = ExitStack()
        self._advance: console.Advance | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the bar, if there is one."""
        self._bar.close()
        self._advance = None

    def say(self, text: str) -> None:
        """Print a line."""
        self.close()
        self._say(text)

    def progress(self, done: int, total: int, doing: str) -> None:
        """Show the progress."""
        if self._advance is None:
            self._advance = self._bar.enter_context(console.progress("bootstrapping"))
        self._advance(done, total, doing)


def _world(swarm_up: Connection) -> Any:
    """Return the world; None: there is none.

    Raises:
        SwarmError: if the swarm has one that does not answer.
    """
    from hitab_client import SwarmError

    if swarm_up.record is not None and not swarm_up.record.world:
        return None
    try:
        swarm_up.world.wait()
    except SwarmError:
        if swarm_up.has_world:
            raise
        return None  # robots that were started by hand
    return swarm_up.world


def _kept_in(folder: Any) -> Path:
    """Return the folder that keeps the generations; one for all robots started by hand."""
    from hitab_client.run_folder import state_home

    return state_home() if folder is None else folder.path


def _write(json: str | None, read: list[Any], by: str = "seconds", least: bool = False) -> None:
    from hitab_client.bootstrapping import Generations, record_of

    def plain(one: Generation | Generations) -> dict[str, Any]:
        if not isinstance(one, Generations):
            return record_of(one)
        best = one.best(by, least=least)
        return {
            "agent": one.agent,
            "behavior": one.behavior,
            "current": one.current,
            "best": None if best is None else best.number,
            "generations": [record_of(g) for g in one.all],
        }

    console.write_json(json, [plain(one) for one in read])
