"""The verb that sets where an agent holds its world: break."""

from __future__ import annotations

from typing import Annotated

import typer

from hitab_cli.verbs.operating import say_done
from hitab_cli.verbs.verb_connection import connection
from hitab_client import console
from hitab_client.terminal.cli_options import AgentName, SwarmName
from hitab_core.operations import SetBreakpoints


def set_breakpoints(
    agent: AgentName,
    breakpoints: Annotated[list[str] | None, typer.Argument(show_default=False)] = None,
    clear: Annotated[bool, typer.Option("--clear")] = False,
    swarm: SwarmName = None,
) -> None:
    """Hold the world when an agent is about to enter a state; without any, list the breakpoints.

    The world pauses before the agent acts; `hitab world resume` continues. A robot's agent does
    not wait: its status tells that it was there.

    Args:
        breakpoints: A state such as Pass, a change such as "ControlBall -> Pass", or unsure, on
            any level; these replace earlier ones.
        clear: Remove all.

    Examples:
      hitab break keeper_1 "ControlBall -> Pass" unsure
      hitab break keeper_1
      hitab break keeper_1 --clear
    """
    if clear and breakpoints:
        raise typer.BadParameter("--clear removes all breakpoints; give none with it")
    with connection(swarm) as swarm_up:
        if clear or breakpoints:
            say_done(swarm_up, agent, SetBreakpoints(tuple(breakpoints or ())))
            return
        status = swarm_up.agents.await_agent(agent)
        for one in status.breakpoints or ["no breakpoints"]:
            console.say(one)
        if status.held:
            console.say(f"held: {status.held}")
