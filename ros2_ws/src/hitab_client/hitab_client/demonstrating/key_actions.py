"""Actions that a demonstrator triggers with one key, on a terminal, a stick or a page."""

from __future__ import annotations

from hitab_msgs.msg import AgentStatus, WorldState, WorldStatus

from hitab_client.errors import SwarmError
from hitab_client.swarm_client import ACKNOWLEDGE_SECONDS, SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core import FLAGS, quantity
from hitab_ros.call import blocking

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
    sequence: int = 0,
    seconds: float = ACKNOWLEDGE_SECONDS,
    demonstrator: str = "",
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
        sequence: the command's number; 0 for a new number.
        seconds: timeout for the agent's acknowledgement.
        demonstrator: name of the demonstrator; empty for the client's own.

    Raises:
        SwarmError: if the agent is missing, refuses, or does not acknowledge.
    """
    status = await agents.await_agent.coroutine(agent)
    if status.mode in (AgentStatus.IDLE, AgentStatus.PERFORMING):
        await agents.perform.coroutine(agent, behavior)
        kept = f': t continues that of "{status.training}"' if status.training else ""
        return f"{agent} performs {behavior}; it learns from commands only in training{kept}"
    if status.mode == AgentStatus.TESTING:
        await agents.set_mode.coroutine(agent, AgentStatus.TRAINING)
    paused = world.status is not None and world.status.mode == WorldState.PAUSED
    status = await agents.command.coroutine(
        agent,
        behavior,
        seen=0 if paused else seen,  # the paused world has not changed since
        pace=simulated(1.0, world.status, world.speed),
        sequence=sequence,
        seconds=seconds,
        demonstrator=demonstrator,
        world=world,
    )
    return outcome(agent, behavior, status)


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
    return seconds * (status.factor if status.pace == "realtime" else speed)


def earlier(world: WorldClient) -> float:
    """Return the simulated time by which one key press dates a command back, s.

    The world's pace while it runs counts, since a person may pause it to correct.
    """
    status = world.status
    if status is not None:
        status = WorldStatus(mode=WorldState.RUNNING, pace=status.pace, factor=status.factor)
    return simulated(EARLIER_SECONDS, status, world.speed) or EARLIER_SECONDS


def outcome(agent: str, behavior: str, status: AgentStatus) -> str:
    """Return the outcome of a command, from the status that acknowledges it."""
    state = behavior if behavior in FLAGS else next(iter(status.active_path), behavior)
    done = f": {status.left} -> {state}" if status.left else f" performs {state}"
    return (
        f"{agent}{done}; {status.behavior} has "
        f"{quantity(status.examples, 'example')} ({status.default_examples} default)"
        + (f"; {agent} {status.note}" if status.note else "")
    )


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
    await agents.retime.coroutine(agent, [last.number], ago)
    now = {e.number: e for e in (await agents.training.coroutine(agent)).examples}[last.number]
    return f"{now.state} → {now.next_state}: {now.ago:.2f} s ago, instead of {last.ago:.2f} s ago"


def other_mode(status: AgentStatus) -> str:
    """Return the mode that one key switches to: testing or training."""
    training = status.mode == AgentStatus.TRAINING
    return AgentStatus.TESTING if training else AgentStatus.TRAINING
