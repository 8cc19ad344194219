"""What a demonstrator does with one key, whatever the key is on: a terminal, a stick or a page."""

from __future__ import annotations

from hitab_msgs.msg import AgentStatus
from hitab_msgs.srv import EditExamples

from hitab_client.demonstrating.timing import due, earlier
from hitab_client.errors import SwarmError
from hitab_client.swarm_client import ACKNOWLEDGE_SECONDS, SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core import FLAGS, quantity


def command(
    agents: SwarmClient,
    world: WorldClient,
    agent: str,
    behavior: str,
    *,
    reaction: float,
    seen: int,
    sequence: int = 0,
    seconds: float = ACKNOWLEDGE_SECONDS,
    demonstrator: str = "",
) -> AgentStatus:
    """Command a behavior; if the agent is testing what it has learned, take over first.

    Args:
        agents: of the swarm.
        world: that the person sees.
        agent: to command.
        behavior: with its targets.
        reaction: the person's reaction time, s.
        seen: the world's cycle that the person saw; 0: the last one.
        sequence: number of the command; 0: a new one.
        seconds: how long to wait for the agent's acknowledgement.
        demonstrator: who commands; empty: whoever the client says.

    Raises:
        SwarmError: if the agent is missing, refuses, or does not acknowledge.
    """
    if agents.await_agent(agent).mode == AgentStatus.TESTING:
        agents.set_mode(agent, AgentStatus.TRAINING)
    when = due(world, reaction, seen)
    return agents.command(
        agent,
        behavior,
        ago=when.ago,
        seen=when.seen,
        sequence=sequence,
        seconds=seconds,
        demonstrator=demonstrator,
        world=world,
    )


def outcome(agent: str, behavior: str, status: AgentStatus) -> str:
    """Return what came of a command, from the status that acknowledges it."""
    path = " > ".join(status.active_path) or behavior
    done = f"raised {behavior}" if behavior in FLAGS else f"performs {path}"
    return (
        f"{agent} {done}; {status.behavior} has "
        f"{quantity(status.examples, 'example')} ({status.default_examples} default)"
        + (f"; {agent} {status.note}" if status.note else "")
    )


def put_earlier(agents: SwarmClient, world: WorldClient, agent: str) -> str:
    """Have the last command be due a little earlier than it is at present; return what it is.

    Raises:
        SwarmError: if there is none, or that time is not kept.
    """
    examples = agents.list_examples(agent).examples
    last = max(examples, key=lambda e: (e.command, -e.number), default=None)
    if last is None:
        raise SwarmError("There is no command yet that could have been due earlier.")
    ago = round(last.ago + earlier(world), 3)
    agents.edit_examples(agent, EditExamples.Request.RETIME, [last.number], ago=ago)
    now = {e.number: e for e in agents.list_examples(agent).examples}[last.number]
    return f"{now.state} → {now.next_state}: {now.ago:.2f} s ago, instead of {last.ago:.2f} s ago"


def other_mode(status: AgentStatus) -> str:
    """Return what one key switches to: testing what was learned, or training."""
    training = status.mode == AgentStatus.TRAINING
    return AgentStatus.TESTING if training else AgentStatus.TRAINING
