"""The agent that is trained, and its teammates: what must hold before a generation is made."""

from __future__ import annotations

from collections.abc import Sequence

from hitab_msgs.msg import AgentStatus

from hitab_client.errors import SwarmError
from hitab_client.learned import Learned
from hitab_client.swarm_client import SwarmClient
from hitab_core import START, Fix, quantity


def training_of(swarm: SwarmClient, agent: str) -> Learned:
    """Return what is being trained.

    Raises:
        SwarmError: if nothing is, or nothing could be performed of it.
    """
    if not swarm.await_agent(agent).training:
        raise SwarmError(
            f"{agent} is not training anything, so there is no next generation",
            Fix.TRAIN(agent=agent),
            Fix.TRAIN_FURTHER(agent=agent),
        )
    training = swarm.training(agent)
    if not any(example.state == START for example in training.examples):
        raise SwarmError(
            f'no example of "{training.name}" leaves Start, so that {agent} and its team mates '
            "would do nothing; command its first behavior from the beginning",
            Fix.DEMONSTRATE(agent=agent),
        )
    return training


def refuse_unsaved(swarm: SwarmClient, agent: str) -> None:
    """Raise if a training has examples that no saved behavior has."""
    if not swarm.await_agent(agent).training:
        return
    training = swarm.training(agent)
    try:
        saved = _marks(swarm.behavior(agent, training.name))
    except SwarmError:
        saved = set()
    differing = _marks(training) ^ saved
    if differing:
        raise SwarmError(
            f'the training of "{training.name}" on {agent} has '
            f"{quantity(len(differing), 'example')} changed since it was saved; give them up with "
            "--discard",
            Fix.NEXT_GENERATION(agent=agent),
        )


def mates_of(swarm: SwarmClient, agent: str, to: Sequence[str]) -> list[str]:
    """Return the teammates, once all are there and free."""
    swarm.await_agents()
    for mate in to or swarm.expected:
        swarm.await_agent(mate)
    mates = [mate for mate in to or swarm.mates_of(agent) if mate != agent]
    for mate in mates:
        if swarm.statuses[mate].mode in (AgentStatus.TRAINING, AgentStatus.TESTING):
            raise SwarmError(
                f"{mate} is in training itself; name the others with --to",
                Fix.SAVE(agent=mate),
                Fix.DISCARD(agent=mate),
            )
    return list(dict.fromkeys(mates))


def _marks(learned: Learned) -> set[tuple[int, int, str, str]]:
    """Return what identifies the examples of a training, whatever features it uses."""
    return {(e.command, e.cycle, e.state, e.next_state) for e in learned.examples}
