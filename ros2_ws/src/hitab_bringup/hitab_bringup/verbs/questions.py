"""Verbs for what an agent is not sure of: questions, answer, caution."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer

from hitab_bringup.verbs.connection import connection
from hitab_client import console
from hitab_client.command_options import AgentName, JsonPath, SwarmName

PANEL = "Train"


def register(app: typer.Typer) -> None:
    """Add these verbs to the command."""
    app.command(rich_help_panel=PANEL)(questions)
    app.command(rich_help_panel=PANEL)(answer)
    app.command(rich_help_panel=PANEL)(caution)


def questions(agent: AgentName, swarm: SwarmName = None, json: JsonPath = None) -> None:
    """Show what an agent asks about its examples.

    It asks when commands contradict each other, when an example made it do what you corrected,
    when it was shown too little somewhere, and when several explanations fit what it was shown.

    Example:

      hitab questions keeper_1
    """
    with connection(swarm) as swarm_up:
        found = swarm_up.agents.questions(agent)
    if json != "-":
        if not found.questions:
            console.say(f"{agent} has no question")
        for question in found.questions:
            console.say(f"{question.number}. {question.text}")
            for index, choice in enumerate(question.choices):
                proposed = " (proposed)" if index == question.proposed else ""
                console.say(f"   {choice}: {question.effects[index]}{proposed}")
        if found.questions:
            number = found.questions[0].number
            console.say(
                f"`hitab answer {agent} {number}` answers as proposed, "
                f"`hitab answer {agent} {number} CHOICE` otherwise."
            )
    console.write_json(
        json,
        {
            "questions": [_record(question) for question in found.questions],
            "answered": list(found.answered),
        },
    )


def _record(question: Any) -> dict[str, Any]:
    situation = zip(question.features, question.situation, strict=True)
    return {
        "number": question.number,
        "kind": question.kind,
        "text": question.text,
        "state": question.state,
        "examples": list(question.examples),
        "choices": dict(zip(question.choices, question.effects, strict=True)),
        "proposed": question.choices[question.proposed],
        "situation": {name: v for name, v in situation if not math.isnan(v)},
    }


def answer(
    agent: AgentName,
    number: Annotated[int, typer.Argument(help="Of the question, see `hitab questions`.")],
    choice: Annotated[
        str, typer.Argument(help="One of its choices; without it, the proposed one.")
    ] = "",
    dismiss: Annotated[
        bool, typer.Option("--dismiss", help="Change nothing, and do not ask this again.")
    ] = False,
    swarm: SwarmName = None,
) -> None:
    """Answer a question of an agent; `hitab undo` takes the answer back.

    Examples:

      hitab answer keeper_1 1

      hitab answer keeper_1 2 Stop

      hitab answer keeper_1 3 --dismiss
    """
    with connection(swarm) as swarm_up:
        done = swarm_up.agents.answer(agent, number, choice, dismiss=dismiss)
    console.say(done.message)


def caution(
    agent: AgentName,
    when_unsure: Annotated[
        str,
        typer.Argument(
            help="go_on, halt or hand_back; without it, show what it does.", metavar="WHEN_UNSURE"
        ),
    ] = "",
    support: Annotated[
        float,
        typer.Option(
            help="Unsure of a decision that rests on fewer examples than this. Default: any.",
            show_default=False,
        ),
    ] = 0.0,
    distance: Annotated[
        float,
        typer.Option(
            help="Unsure farther than this from every example; 1 is about as far as the examples "
            "are apart. Default: any.",
            show_default=False,
        ),
    ] = 0.0,
    swarm: SwarmName = None,
) -> None:
    """Say what an agent does when it is unsure; `hitab status` shows why it is.

    An agent is unsure of a decision that rests on few examples, or in a situation far from all
    examples. It then goes on (go_on), does nothing until it is sure (halt), or gives control to
    the demonstrator (hand_back).

    Examples:

      hitab caution keeper_1

      hitab caution keeper_1 halt --distance 3

      hitab caution keeper_1 hand_back --support 2

      hitab caution keeper_1 go_on
    """
    from hitab_core import caution_in_words

    if not when_unsure and (support or distance):
        raise typer.BadParameter(
            "--support and --distance need halt or hand_back, as in "
            f"`hitab caution {agent} halt --distance 3`"
        )
    with connection(swarm) as swarm_up:
        if when_unsure:
            done = swarm_up.agents.set_caution(
                agent, when_unsure, support=support, distance=distance
            )
            console.say(done.message)
            return
        status = swarm_up.agents.await_agent(agent)
    words = caution_in_words(status.when_unsure, status.unsure_support, status.unsure_distance)
    console.say(f"{agent}: {words}")
    if status.unsure:
        console.say(f"It is unsure now: {status.unsure}")
