"""Verb for an agent's questions about its examples: questions."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer

from hitab_cli.verbs.operating import say_done
from hitab_cli.verbs.printing import plain
from hitab_cli.verbs.verb_connection import connection
from hitab_client import console
from hitab_client.terminal.cli_options import AgentName, JsonPath, SwarmName
from hitab_client.terminal.cli_remedies import called, with_commands
from hitab_core.operations import AnswerQuestion

SHOWN_MAX = 5
"""The most states that are shown of what comes of an answer."""


def questions(
    agent: AgentName,
    answer: Annotated[int | None, typer.Option(metavar="NUMBER")] = None,
    choice: str = "",
    dismiss: Annotated[int | None, typer.Option(metavar="NUMBER")] = None,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show an agent's questions about its examples, or answer one.

    An agent asks when commands contradict each other, when nothing like a situation was shown,
    when a late command may be meant for either of two moments, and when another feature explains
    the examples as well. Below each answer is what the agent would do next, and the part of the
    situations met that it would decide otherwise. `hitab back --to CYCLE` puts the world where a
    situation was met, within a minute. `hitab undo` reverts an answer. Above the
    questions are signs that the behavior does not work: cycles of states, and events that did not
    occur in fifty episodes of a test.

    Args:
        answer: Answer this question, as proposed or with --choice.
        choice: One of the question's choices.
        dismiss: Do not ask this question again; change nothing.

    Examples:
      hitab questions keeper_1
      hitab questions keeper_1 --answer 1
      hitab questions keeper_1 --answer 2 --choice Stop
      hitab questions keeper_1 --dismiss 3
    """
    number = answer if answer is not None else dismiss
    if choice and answer is None:
        raise typer.BadParameter("--choice needs a question: --answer NUMBER")
    with connection(swarm) as swarm_up:
        if number is not None:
            say_done(swarm_up, agent, AnswerQuestion(number, choice, answer is None))
            return
        found = swarm_up.agents.training(agent, searched=True)
    lines = [with_commands(str(remark), [remark.remedy]) for remark in found.remarks]
    lines += [] if found.questions else [f"{agent} has no question"]
    for question in found.questions:
        met = f" (cycle {question.cycle})" if question.cycle else ""
        lines.append(f"{question.number}. {question.text}{met}")
        for offered in question.choices:
            proposed = " (proposed)" if offered.name == question.proposed else ""
            lines.append(f"   {offered.name}: {offered.effect}{proposed}")
            if then := " -> ".join(offered.states[:SHOWN_MAX]):
                lines.append(f"      then {then}; {offered.changes:.0%} of what was met changes")
    if found.questions:
        proposes = any(question.proposed for question in found.questions)
        lines.append(
            f"`{called()} questions {agent} --answer {found.questions[0].number} --choice CHOICE` "
            f"answers{'; without --choice, as proposed' if proposes else ''}."
        )
    records = [_record(question) for question in found.questions]
    data = {"questions": records, "answered": list(found.answered)}
    remarks = [{"code": r.code.name, **dict(r.arguments)} for r in found.remarks]
    console.show(json, {**data, "remarks": remarks}, *lines)


def _record(question: Any) -> dict[str, Any]:
    return {
        **plain(question, "number kind text state examples cycle"),
        "choices": {choice.name: choice.effect for choice in question.choices},
        "changes": {choice.name: choice.changes for choice in question.choices},
        "proposed": question.proposed,
        "situation": {r.feature: r.value for r in question.situation if not math.isnan(r.value)},
    }
