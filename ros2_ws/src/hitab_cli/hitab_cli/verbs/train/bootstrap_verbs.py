"""Verbs of behavior bootstrapping: next, back, list."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_cli.verbs.verb_connection import connection
from hitab_client import SwarmError, console
from hitab_client.terminal.cli_options import AgentName, JsonPath, SwarmName
from hitab_core import Fix, has

if TYPE_CHECKING:
    from hitab_client.bootstrapping import Generation

app = typer.Typer(
    help="Train a team step by step: one agent learns among teammates that perform the behavior "
    "learned so far. For behaviors that depend on the teammates."
)

To = Annotated[list[str] | None, typer.Option(help="A teammate. Repeatable. Default: all others.")]
Episodes = Annotated[int, typer.Option(help="Episodes to play for the score; 0: no score.", min=0)]
Seed = Annotated[int, typer.Option(help="Seed of these episodes.", min=0)]
WAIT = 'Let the agent act afterwards until this holds, such as "{said: keeper_2}".'
Wait = Annotated[str, typer.Option(metavar="CONDITION", help=WAIT, show_default=False)]
WITHIN = "Give up waiting after so many s. Default: never."
Within = Annotated[float, typer.Option(help=WITHIN, min=0.0, show_default=False)]


@app.command("next")
def next_(
    agent: AgentName,
    to: To = None,
    episodes: Episodes = 20,
    seed: Seed = 1,
    note: str = "",
    wait: Wait = "",
    within: Within = 1e9,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Make the next generation: save the behavior in training, and train on among the teammates.

    The teammates receive the behavior and perform it from Start, and it is evaluated. The training
    continues with the examples so far, in the world as it was. The number of a generation is the
    version of the behavior in the agent's library.

    Args:
        note: Text to keep with the generation.

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
    within: Within = 1e9,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Return to a generation, which becomes the next one; the training continues from it.

    Behaviors that the generation uses stay as they are now.

    Args:
        behavior: The bootstrapped behavior.
        generation: Number of the generation, see `hitab bootstrap list`, or any version in the
            library.
        discard: Discard examples that no generation contains.

    Example:
      hitab bootstrap back keeper_1 Keepaway 2
    """
    options = {"to": to or (), "episodes": episodes, "seed": seed, "wait": wait, "within": within}
    _make(swarm, json, options, "back", agent, behavior, generation, discard)


@app.command("list")
def list_(
    agent: AgentName,
    behavior: Annotated[str, typer.Argument()] = "",
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """List the generations of an agent's behaviors, with their scores.

    A score is the mean of a measure over a few episodes, with its standard error. The measures are
    the length of an episode and those that the world reports.

    Args:
        behavior: A behavior. Default: all.

    Examples:
      hitab bootstrap list keeper_1
      hitab bootstrap list keeper_1 Keepaway
    """
    from hitab_client.bootstrapping import generations_folder, read_generations
    from hitab_client.connecting.domain_ids import chosen_by_user
    from hitab_client.runs.swarm_choice import find_meant

    found = find_meant(swarm, chosen_by_user())
    folder = generations_folder(found[0].path if found else None, agent)
    bootstrapped = sorted(path.stem for path in folder.glob("*.yaml"))
    if not bootstrapped or (behavior and behavior not in bootstrapped):
        what = f"{behavior} of {agent}" if behavior else agent
        raise SwarmError(
            f"{what} has no generations {has(bootstrapped, behavior)}",
            Fix.NEXT_GENERATION(agent=agent),
        )
    known = {
        name: read_generations(folder, name) for name in ([behavior] if behavior else bootstrapped)
    }
    plain = [
        {"agent": agent, "behavior": name, "generations": [one.model_dump() for one in all_]}
        for name, all_ in known.items()
    ]
    console.show(json, plain, *(_table(agent, name, all_) for name, all_ in known.items()))


def _table(agent: str, behavior: str, known: Sequence[Generation]) -> Any:
    figures = list(dict.fromkeys(name for one in known for name in one.score.figures))
    rows = [
        (
            str(one.version),
            *(str(one.score.figures.get(name, "")) for name in figures),
            one.score.played,
            str(one.examples),
            one.at.replace("T", " ")[:16],
            one.by,
            one.note,
        )
        for one in known
    ]
    columns = ("generation", *figures, "score of", "examples", "when (UTC)", "who", "note")
    return console.table(columns, rows, f"{behavior}, trained on {agent}")


def _make(
    swarm: str | None,
    json: str | None,
    options: dict[str, Any],
    step: str,
    agent: str,
    *given: Any,
) -> None:
    """Make a generation by a step of bootstrapping."""
    from hitab_client.bootstrapping import Bootstrapping

    options["say"] = console.note if json == "-" else console.say
    with connection(swarm) as swarm_up, console.progress("bootstrapping") as progress:
        folder = swarm_up.folder.path if swarm_up.folder else None
        options["progress"] = progress
        steps = Bootstrapping(swarm_up.agents, swarm_up.await_world(), folder, **options)
        generation = getattr(steps, step)(agent, *given)
    text = f"{agent} is in training mode, with generation {generation.version}"
    console.show(json, [generation.model_dump()], text)
