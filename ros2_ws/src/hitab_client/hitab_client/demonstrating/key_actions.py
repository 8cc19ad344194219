"""Actions that a demonstrator triggers with one key, on a terminal, a stick or a page."""

from __future__ import annotations

from copy import copy

from hitab_msgs.msg import AgentStatus, WorldState, WorldStatus

from hitab_client.errors import SwarmError
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core.operations import (
    Command,
    Perform,
    RetimeExamples,
    TakeOver,
    Test,
)
from hitab_core.training.operation import Operation
from hitab_ros.call import blocking
from hitab_ros.timing import ANSWER_S

EARLIER_SECONDS = 0.2
"""Time by which one key press dates a command back, in seconds of the person's time."""


@blocking
async def command(
    agents: SwarmClient,
    world: WorldClient,
    agent: str,
    behavior: str,
    *,
    seen: int,
    exact: bool = False,
    id: str = "",
    by: str = "",
    seconds: float = ANSWER_S,
) -> str:
    """Command a behavior in training, or make the agent perform it; return the outcome.

    If the agent is testing, take over first.

    Args:
        agents: client of the swarm's agents.
        world: client of the world that the person sees.
        agent: name of the agent.
        behavior: behavior with its targets.
        seen: the world's cycle that the person saw; 0 for the last one. While the world runs, the
            agent estimates the person's reaction time before that cycle.
        exact: whether the person chose that cycle looking back, and did not react to it.
        id: the same when the command is sent again, see `Operation`.
        by: name of the demonstrator; empty for the client's own.
        seconds: timeout for the agent's answer.

    Raises:
        SwarmError: if the agent is missing, refuses, or does not answer.
    """
    status = await agents.await_agent.coroutine(agent)
    if status.mode in (AgentStatus.IDLE, AgentStatus.PERFORMING):
        await agents.do.coroutine(agent, Perform(behavior, id=id, by=by), seconds=seconds)
        kept = (
            f': t continues that of "{status.training.automaton}"'
            if status.training.automaton
            else ""
        )
        return f"{agent} performs {behavior}; it learns from commands only in training{kept}"
    if status.mode == AgentStatus.TESTING:
        await agents.do.coroutine(agent, TakeOver(by=by), seconds=seconds)
    paused = world.status is not None and world.status.mode == WorldState.PAUSED
    meant = Command(
        behavior,
        # The paused world has not changed since.
        seen=0 if paused and not exact else seen,
        pace=simulated(1.0, world.status, world.speed),
        exact=exact or paused,
        id=id,
        by=by,
    )
    answer = await agents.do.coroutine(agent, meant, seconds=seconds, world=world)
    return str(answer.message)


def simulated(seconds: float, status: WorldStatus | None, speed: float = 1.0) -> float:
    """Return the simulated time that passes during some seconds of a person's time.

    Args:
        seconds: seconds of the person's time.
        status: the world's status; None if missing, or for robots, whose time is the person's.
        speed: observed speed of a world in lockstep, simulated seconds per second.
    """
    if status is None:
        return seconds
    if status.mode == WorldState.PAUSED:
        return 0.0  # the world is paused
    if status.pace != "realtime":
        return seconds * speed
    # Of a world that cannot be slowed down, the factor for teaching is 0.
    return seconds * status.factor * ((status.taught and status.teaching) or 1.0)


def earlier(world: WorldClient) -> float:
    """Return the simulated time by which one key press dates a command back, s.

    The world's pace while it runs counts, since a person may pause it to correct.
    """
    status = world.status
    if status is not None:
        status = copy(status)
        status.mode = WorldState.RUNNING
    return simulated(EARLIER_SECONDS, status, world.speed) or EARLIER_SECONDS


@blocking
async def put_earlier(agents: SwarmClient, world: WorldClient, agent: str) -> str:
    """Date the last command back a little further; return a text with the total.

    Raises:
        SwarmError: if there is no command, or that time is no longer recorded.
    """
    examples = (await agents.training.coroutine(agent)).examples
    last = max(examples, key=lambda e: (e.command, -e.number), default=None)
    if last is None:
        raise SwarmError("There is no command yet that could have been due earlier.")
    ago = round(last.ago + earlier(world), 3)
    await agents.do.coroutine(agent, RetimeExamples([last.number], ago))
    now = {e.number: e for e in (await agents.training.coroutine(agent)).examples}[last.number]
    return f"{now.state} → {now.next_state}: {now.ago:.2f} s ago, instead of {last.ago:.2f} s ago"


def toggled(status: AgentStatus) -> Operation:
    """Return the operation of the key for both: test what is trained, or take over."""
    return Test() if status.mode == AgentStatus.TRAINING else TakeOver()
