"""Verbs that train: train, test, undo, redo, save, discard."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from hitab_cli.verbs.operating import bound, operates, say_done
from hitab_cli.verbs.printing import tell_faults
from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import console
from hitab_client.terminal.cli_options import AgentName, SwarmName
from hitab_client.terminal.cli_remedies import called
from hitab_core import has, quantity
from hitab_core.operations import (
    BeginTraining,
    DiscardTraining,
    Redo,
    SaveBehavior,
    SetCaution,
    TakeOver,
    Test,
    Undo,
)
from hitab_core.training.operation import Operation

UNASKED_MAX = 3
"""Number of commands that are discarded without confirmation, since they are quickly repeated."""


def train(
    agent: AgentName,
    automaton: Annotated[str | None, typer.Argument(metavar="behavior")] = None,
    feature: Annotated[list[str] | None, typer.Option("--feature", "-f")] = None,
    state: Annotated[list[str] | None, typer.Option("--state", "-s")] = None,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", "-p", metavar="A=ball")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume")] = False,
    resume_from: Annotated[str, typer.Option("--from")] = "",
    classifier: Annotated[str, typer.Option(metavar="CLASSIFIER")] = "",
    discard: Annotated[bool, typer.Option("--discard")] = False,
    swarm: SwarmName = None,
) -> None:
    """Begin training a behavior; without a name, take control back from a test.

    First choose the features for the decisions: only the named features are used, and
    `hitab vocabulary AGENT` lists them. They can be exchanged later. Then command behaviors with
    `hitab demonstrate`, try the learned behavior with `hitab test`, take over again with
    `hitab train AGENT`, and save.

    To continue from a saved behavior's examples, add --resume; otherwise saving replaces them.

    Args:
        automaton: Name of the behavior; without it, take control back from a test.
        feature: A feature, such as "DistanceTo(ball)". Repeatable. Default: none.
        state: A behavior that may be commanded. Repeatable. Default: any.
        parameter: A parameter and its target during the training. Repeatable.
        resume: Resume from the examples of the saved behavior.
        resume_from: Resume from the examples of another saved behavior, or of an earlier version,
            such as Keepaway@2.
        classifier: Instead of the tree, one of scikit-learn: sklearn.MODULE.CLASS(KEYWORD=VALUE).
        discard: First discard the unsaved training, if any.

    Examples:
      hitab train keeper_1 ApproachBall -f "DistanceTo(ball)"
      hitab train keeper_1 Approach -p A=ball -f "DistanceTo(A)" -s GoFast -s Stop
      hitab train keeper_1 Keepaway --resume
      hitab train keeper_1
    """
    targets = bound(parameter or [])
    taking_over = automaton is None and not resume_from
    if taking_over and any((feature, state, parameter, resume, classifier, discard)):
        raise typer.BadParameter(
            f"name the behavior to train, as in `{called()} train {agent} NAME`"
        )
    begin: Operation = TakeOver()
    if not taking_over:
        begin = BeginTraining(
            automaton or resume_from,
            feature or (),
            state or (),
            targets,
            resume_from or (automaton if resume and automaton else ""),
            classifier,
            discard,
        )
    with connection(swarm) as swarm_up:
        say_done(swarm_up, agent, begin)


@operates(Test)
def start_testing(
    swarm_up: Connection,
    agent: str,
    test: Test,
    when_unsure: Annotated[str, typer.Option(metavar="go_on|halt|hand_back")] = "",
    distance: Annotated[float, typer.Option(show_default=False)] = 0.0,
) -> None:
    """Give control to the learned behavior, without a reset.

    The choice for unsure decisions also applies to later performances; `hitab status` shows why a
    decision is unsure.

    Args:
        when_unsure: From now on, when a decision is unsure: go on, do nothing until it is sure,
            or give control to the demonstrator.
        distance: A decision is unsure if farther than this from every example; 1 is the typical
            distance of examples. Default: any distance.

    Examples:
      hitab test keeper_1 --restart
      hitab test keeper_1 --when-unsure halt --distance 3
    """
    if when_unsure or distance:
        say_done(swarm_up, agent, SetCaution(when_unsure, distance))
    tell_faults(say_done(swarm_up, agent, test).status)


undo = operates(Undo, "hitab undo keeper_1")(say_done)
redo = operates(Redo, "hitab redo keeper_1")(say_done)


@operates(SaveBehavior)
def save(
    swarm_up: Connection,
    agent: str,
    saving: SaveBehavior,
    yes: Annotated[bool, typer.Option("--yes", "-y")] = False,
) -> None:
    """Trim the learned behavior and add it to the agent's library.

    The behavior can then be commanded, as a state of a higher behavior. On a terminal, the agent's
    open questions are shown before, and saving needs a confirmation.

    Args:
        yes: Save without asking, whatever is open.
        automaton: A new name. Default: the name given to `hitab train`.
        bindings: Replace a target or parameter. Repeatable.

    Examples:
      hitab save keeper_1
      hitab save keeper_1 --name Approach --bind ball=A
    """
    asks = not yes and _is_terminal() and swarm_up.agents.await_agent(agent).training.automaton
    if asks and (asked := swarm_up.agents.training(agent, searched=True).questions):
        for question in asked:
            console.note(f"{question.number}. {question.text}")
        console.note(f"`{called()} questions {agent}` shows the answers.")
        these = quantity(len(asked), "question")
        typer.confirm(f"Save with {these} open?", default=True, abort=True, err=True)
    answer = swarm_up.agents.do(agent, saving)
    console.say_answer(answer, f"{answer.message}: {answer.path}")
    targets = swarm_up.agents.vocabulary(agent).targets if saving.bindings else []
    for parameter in saving.bindings.values():
        if parameter not in targets:
            console.say(
                f'"{parameter}" is now a parameter, since no target has this name '
                f"{has(targets, parameter)}"
            )
    if answer.trimmed:
        console.say(f"trimmed: {', '.join(answer.trimmed)}")


@operates(DiscardTraining)
def discard(
    swarm_up: Connection,
    agent: str,
    discarding: DiscardTraining,
    yes: Annotated[bool, typer.Option("--yes", "-y")] = False,
) -> None:
    """Discard a training and its unsaved examples; the agent is idle afterwards.

    On a terminal, discarding more than a few commands needs a confirmation. Saved behaviors stay.
    The examples are kept in the agent's database, with those of earlier trainings.

    Args:
        yes: Do not ask, however many examples there are.

    Examples:
      hitab discard keeper_1
      hitab discard keeper_1 --yes
    """
    if not yes and _is_terminal():
        training = swarm_up.agents.await_agent(agent).training
        if training.examples - training.default_examples > UNASKED_MAX:
            examples = quantity(training.examples, "unsaved example")
            question = f'Discard the training of "{training.automaton}" with its {examples}?'
            typer.confirm(question, abort=True, err=True)
    say_done(swarm_up, agent, discarding)


def _is_terminal() -> bool:
    return sys.stdin.isatty() and sys.stderr.isatty()
