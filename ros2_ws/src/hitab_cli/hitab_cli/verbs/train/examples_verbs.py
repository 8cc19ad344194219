"""Verbs on the examples of a training: list, delete, relabel, retime, and their features."""

from __future__ import annotations

from dataclasses import asdict
from difflib import get_close_matches
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from hitab_cli.verbs.operating import operates, say_done
from hitab_cli.verbs.printing import as_text
from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import as_direction, console
from hitab_client.terminal.cli_options import AgentName, JsonPath, SwarmName
from hitab_core import RADIANS, ExampleKind, HitabError, quantity, shown_unit, shown_value
from hitab_core.codec import plain_values, to_dict
from hitab_core.operations import (
    ChooseFeatures,
    DeleteExamples,
    RelabelExamples,
    RetimeExamples,
)

if TYPE_CHECKING:
    from hitab_core.assistant import TrainingCost

COUNT_FIELDS = ("commands", "examples", "wasted", "undos", "structures", "proposals")


class ExamplesGroup(TyperGroup):
    """Takes an agent's name without a command as a request to list its examples."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command to run and its arguments."""
        if not (args[0] in self.commands or get_close_matches(args[0], self.commands)):
            args = ["list", *args]
        return super().resolve_command(ctx, args)


app = typer.Typer(
    cls=ExamplesGroup,
    help="List and correct the examples of a training: `hitab examples keeper_1` lists them.",
)


@app.command("list")
def examples_list(
    agent: AgentName,
    automaton: Annotated[str, typer.Argument(metavar="behavior")] = "",
    cost: Annotated[bool, typer.Option("--cost")] = False,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """List the examples of the current training, or of a trained behavior.

    With --cost, `time` and `simulated` are the times of the training by the clock and in the
    world, without pauses of more than five minutes and the time while the swarm was down.
    `commands` and `undos` count your commands and undos. `examples` counts the final examples.
    `wasted` counts the recorded examples that were not learned from: they were deleted or undone,
    or are listed as overruled, since a command in the same place contradicts them. `structures`
    counts the sets of features that were tried: 1, and one more for each `hitab examples
    features`. `proposals` counts the agent's questions that you answered as proposed.

    Args:
        automaton: A trained behavior. Default: the current training.
        cost: Show the cost of the trainings instead.

    Examples:
      hitab examples keeper_1
      hitab examples list keeper_1 ApproachBall --json examples.json
      hitab examples keeper_1 --cost
    """
    with connection(swarm) as swarm_up:
        if cost:
            _show_costs(swarm_up.agents.report(agent, automaton), json)
            return
        agents = swarm_up.agents
        found = agents.behavior(agent, automaton) if automaton else agents.training(agent)
    if not found.is_automaton:
        raise HitabError(f"{automaton} is a basic behavior: it was not learned from examples")
    units, kinds = found.units, [scale.kind for scale in found.scales]
    readable = list(map(str, found.readable))
    late = any(e.ago for e in found.examples)
    names = (
        f"{f}, {shown_unit(unit)}" if unit == RADIANS else f
        for f, unit in zip(found.feature_labels, units, strict=True)
    )
    columns = ("number", "in", *names, "go to", "kind", "command", "cycle", *["s ago"] * late)
    rows = [
        (
            str(e.number),
            e.state,
            *map(_shown, e.features, units, kinds),
            found.commanded(e),
            ExampleKind(e.kind).shown,
            str(e.command),
            str(e.cycle),
            *[f"{e.ago:.2g}" if e.ago else ""] * late,
        )
        for e in found.examples
    ]
    title = f"{found.name}: {quantity(len(found.examples), 'example')}"
    if superseded := sum(e.kind == ExampleKind.SUPERSEDED for e in found.examples):
        title += f", {superseded} {ExampleKind.SUPERSEDED.shown} by a command"
    data = [
        to_dict(e) | {"readings": dict(zip(readable, plain_values(e.readings), strict=False))}
        for e in found.examples
    ]
    console.show(
        json,
        {"automaton": found.name, "features": list(found.feature_labels), "examples": data},
        console.table(columns, rows, title),
    )


def _show_costs(costs: list[TrainingCost], json: str | None) -> None:
    rows = [
        (
            cost.automaton if cost.finished else f"{cost.automaton}, not saved",
            cost.began.replace("T", " ")[:16],
            _duration(cost.wall_seconds),
            _duration(cost.simulated_seconds),
            *(str(getattr(cost, count)) for count in COUNT_FIELDS),
        )
        for cost in costs
    ]
    heads = ("automaton", "began (UTC)", "time", "simulated", *COUNT_FIELDS)
    data = {"trainings": [asdict(cost) for cost in costs]}
    console.show(json, data, console.table(heads, rows))


def _duration(seconds: float) -> str:
    """Return a time in seconds or minutes."""
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60:.1f} min"


def _shown(value: float, unit: str, kind: str) -> str:
    """Return a value for people, with angles in degrees, as in learned rules."""
    value = shown_value(as_direction(value, unit, kind), unit)
    return f"{value:{'.1f' if unit == RADIANS else '.4g'}}"


_RELABEL = (
    "hitab examples relabel keeper_1 5 --to GoSlow",
    'hitab examples relabel keeper_1 5 --to "RunTowards(direction=40)"',
)
for _verb in (
    operates(DeleteExamples, "hitab examples delete keeper_1 3 4"),
    operates(RelabelExamples, *_RELABEL),
    operates(RetimeExamples, "hitab examples retime keeper_1 5 --ago 0.4"),
):
    app.command()(_verb(say_done))


@app.command("features")
@operates(ChooseFeatures)
def examples_features(
    swarm_up: Connection,
    agent: str,
    chosen: ChooseFeatures,
    show: Annotated[bool, typer.Option("--show")] = False,
) -> None:
    """Learn from other features of the same examples; `hitab undo` reverts this.

    Args:
        features: A feature, such as "DistanceTo(ball)". Repeatable.
        show: Only show the result; change nothing.

    Examples:
      hitab examples features keeper_1 -f BallIsKickable --show
      hitab examples features keeper_1 -f BallIsKickable -f "DistanceTo(ball)"
    """
    if show:
        shown = swarm_up.agents.behavior(agent, with_features=chosen.features)
        console.say(as_text(shown))
    else:
        say_done(swarm_up, agent, chosen)
