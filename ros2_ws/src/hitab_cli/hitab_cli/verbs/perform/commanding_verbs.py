"""Verbs that command agents: demonstrate, perform, distribute, vocabulary."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from hitab_cli.verbs.operating import operates, say_done
from hitab_cli.verbs.printing import plain, tell_faults
from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import console
from hitab_client.terminal.cli_options import AgentName, JsonPath, SwarmName
from hitab_client.terminal.cli_remedies import called, with_commands
from hitab_core import FeatureKind, Fix, HitabError, each_once, quantity
from hitab_core.operations import Command, Distribute, Perform, RetimeExamples, Undo


@operates(Command)
def demonstrate(
    swarm_up: Connection,
    agent: str,
    command: Command,
    ago: Annotated[float | None, typer.Option("--ago")] = None,
    cycle: Annotated[int, typer.Option("--cycle", show_default=False)] = 0,
) -> None:
    """Command a behavior in training: the agent performs it now and learns from it.

    The agent records an example: its percept and the change of state. To teach the agent to
    continue here, command the current behavior again. `hitab train` begins a training.

    If a command was due earlier, give the delay with --ago; the example then has the situation of
    that time before you pressed Enter.

    Args:
        behavior: A behavior, such as GoFast, or GoTo(ball).
        ago: Delay of the command, s of your time. Default: the command counts when it arrives.
        cycle: The command is for the percept of this cycle of the last minute, as `hitab why` and
            `hitab perceive --cycle` show it, exactly as if it had come then.
        unrecorded: Only bring the agent into that state, for example to correct its decisions
            there; no example is recorded.

    Examples:
      hitab demonstrate keeper_1 GoFast
      hitab demonstrate keeper_1 GoTo ball
      hitab demonstrate keeper_1 RunTowards direction=40
      hitab demonstrate keeper_1 GoFast --ago 0.5
      hitab demonstrate keeper_1 GoFast --cycle 424
      hitab demonstrate keeper_1 Done
      hitab demonstrate keeper_1 TurnToBall --unrecorded
    """
    if ago and cycle:
        raise typer.BadParameter("--ago and --cycle both say when it was due; give one of them")
    if cycle:
        command = replace(command, seen=cycle, exact=True)
    passed = _passed(swarm_up, agent, ago) if ago else 0.0
    answer = swarm_up.agents.do(agent, command, world=swarm_up.world)
    if passed and answer.examples:
        late = RetimeExamples(answer.examples, passed)
        try:
            swarm_up.agents.do(agent, late)
        except HitabError:
            swarm_up.agents.do(agent, Undo())
            raise
    console.say(answer.message)
    tell_faults(answer.status)
    if answer.status.training.questions:
        questions = quantity(answer.status.training.questions, "question")
        console.say(with_commands(questions, [Fix.QUESTIONS(agent=agent)]))


def _passed(swarm_up: Connection, agent: str, ago: float) -> float:
    """Return the simulated time from some seconds before this command was entered until now, s.

    The world goes on while this process starts and looks for the agent.
    """
    import time

    import psutil  # type: ignore[import-untyped]

    from hitab_client.demonstrating import simulated

    swarm_up.agents.await_agent(agent)
    swarm_up.await_world()
    seconds = ago + time.time() - psutil.Process().create_time()
    return simulated(seconds, swarm_up.world.status, swarm_up.world.speed)


@operates(Perform)
def perform(swarm_up: Connection, agent: str, performed: Perform) -> None:
    """Make an agent perform a behavior from its beginning; without one, stop it.

    A current training is kept with its examples; `hitab train AGENT` resumes it.

    Args:
        behavior: A behavior; without one, stop.

    Examples:
      hitab perform keeper_1 Keepaway
      hitab perform keeper_1
    """
    answer = say_done(swarm_up, agent, performed)
    if performed.behavior:
        tell_faults(answer.status)


@operates(Distribute)
def distribute(swarm_up: Connection, agent: str, sent: Distribute, json: JsonPath = None) -> None:
    """Send a behavior and everything it uses from one agent to the others of its domain.

    Each receiver verifies the files; the output lists which ones accepted it.

    Args:
        behavior: A trained behavior in that agent's library.
        receivers: A receiver. Repeatable. Default: all others of its domain.
        start: Make the receivers perform it, from Start.

    Examples:
      hitab distribute keeper_1 Keepaway --start
      hitab distribute keeper_1 ControlBall --to keeper_2 --to keeper_3
    """
    if sent.targets and not sent.start:
        too_much = sent.targets[0]
        raise typer.BadParameter(
            f'"{too_much}" is too much: targets matter only with --start, and receivers are '
            f"chosen with --to, as in `{called()} distribute {agent} {sent.behavior} --to "
            f"{too_much}`"
        )
    with console.progress("distributing", "agents") as advance:
        report = swarm_up.agents.distribute(
            agent, sent, progress=lambda done, total: advance(done, total, "")
        )
    console.note(report.message)
    lines = each_once([*((name, "accepted") for name in report.accepted), *report.missing.items()])
    fields = ("sequence", "digest", "accepted", "refused", "silent")
    console.show(json, {field: getattr(report, field) for field in fields}, *lines)
    if report.missing:
        have, missing = len(report.accepted), len(report.missing)
        raise HitabError(
            f'only {have} of {have + missing} receivers have "{sent.behavior}" now; solve the '
            "problems of the others, and distribute it again"
        )


def vocabulary(agent: AgentName, swarm: SwarmName = None, json: JsonPath = None) -> None:
    """Show an agent's vocabulary: its behaviors, features and targets."""
    with connection(swarm) as swarm_up:
        words = swarm_up.agents.vocabulary(agent)

    lines = [f"domain    {words.domain}"]
    for b in words.behaviors:
        kinds = ["trained"] * b.trained + ["one-shot"] * b.one_shot
        lines.append(f"behavior  {_with_description(b.name, kinds, b.description)}")
    for f in words.features:
        kind = "circular" if f.kind == FeatureKind.TOROIDAL else f.kind
        kinds = [kind, f.unit] if f.unit else [kind]
        lines.append(f"feature   {_with_description(f.name, kinds, f.description)}")
    lines += [f"target    {name}" for name in words.targets]
    data = {
        "domain": words.domain,
        "behaviors": [plain(b, "name description") for b in words.behaviors],
        "trained": [b.name.split("(")[0] for b in words.behaviors if b.trained],
        "one_shot": [b.name.split("(")[0] for b in words.behaviors if b.one_shot],
        "features": [plain(f, "name kind unit description") for f in words.features],
        "targets": list(words.targets),
    }
    console.show(json, data, *lines)


def _with_description(name: str, kinds: list[str], description: str) -> str:
    """Return a line such as ``Pass  one-shot: kick the ball to a teammate``."""
    meaning = ": ".join(filter(None, (", ".join(kinds), description)))
    return f"{name}  {meaning}" if meaning else name
