"""Actions that a demonstrator triggers with one key, on a terminal, a stick or a page."""

from __future__ import annotations

from hitab_msgs.msg import AgentStatus, WorldState, WorldStatus

from hitab_client.errors import SwarmError
from hitab_client.swarm_client import ACKNOWLEDGE_SECONDS, SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core import FLAGS, quantity
from hitab_ros.call import blocking

EARLIER_SECONDS = 0.2
"""By how much a person has a command be due earlier with one key, in seconds of their own."""


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
    """Command a behavior, or in no training have it performed; return what came of it.

    If the agent is testing, take over first.

    Args:
        agents: of the swarm.
        world: that the person sees.
        agent: to command.
        behavior: with its targets.
        seen: the world's cycle that the person saw; 0 for the last one. While the world runs, the
            agent estimates how long before it the command was due.
        sequence: number of the command; 0 for a new one.
        seconds: how long to wait for the agent's acknowledgement.
        demonstrator: who commands; empty for the client's own.

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
        seen=0 if paused else seen,  # the situation has waited for the person
        pace=simulated(1.0, world.status, world.speed),
        sequence=sequence,
        seconds=seconds,
        demonstrator=demonstrator,
        world=world,
    )
    return outcome(agent, behavior, status)


def simulated(seconds: float, status: WorldStatus | None, speed: float = 1.0) -> float:
    """Return how much simulated time passes for a person in some time of their own.

    Args:
        seconds: of the person.
        status: of the world; None if missing, or a robot's, where time is the person's.
        speed: of a world in lockstep, as seen: simulated seconds in a second.
    """
    if status is None:
        return seconds
    if status.mode == WorldState.PAUSED:
        return 0.0  # the situation waits for the person
    return seconds * (status.factor if status.pace == "realtime" else speed)


def earlier(world: WorldClient) -> float:
    """Return the simulated time by which one key has a command be due earlier, s.

    A person may pause the world to correct: what counts is its pace when it runs.
    """
    status = world.status
    if status is not None:
        status = WorldStatus(mode=WorldState.RUNNING, pace=status.pace, factor=status.factor)
    return simulated(EARLIER_SECONDS, status, world.speed) or EARLIER_SECONDS


def outcome(agent: str, behavior: str, status: AgentStatus) -> str:
    """Return what came of a command, from the status that acknowledges it."""
    state = behavior if behavior in FLAGS else next(iter(status.active_path), behavior)
    done = f": {status.left} -> {state}" if status.left else f" performs {state}"
    return (
        f"{agent}{done}; {status.behavior} has "
        f"{quantity(status.examples, 'example')} ({status.default_examples} default)"
        + (f"; {agent} {status.note}" if status.note else "")
    )


@blocking
async def put_earlier(agents: SwarmClient, world: WorldClient, agent: str) -> str:
    """Have the last command be due a little earlier than at present; return by how much.

    Raises:
        SwarmError: if there is none, or that time is not kept.
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
    """Return what one key switches to: testing what was learned, or training."""
    training = status.mode == AgentStatus.TRAINING
    return AgentStatus.TESTING if training else AgentStatus.TRAINING
