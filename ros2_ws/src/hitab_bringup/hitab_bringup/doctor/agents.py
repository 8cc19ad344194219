"""Asks the agents of the swarms that are up what hinders them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hitab_msgs.msg import AgentStatus

from hitab_bringup.doctor.finding import Finding, warning
from hitab_client import RosLink, RunRecord, SwarmClient
from hitab_client.commands import as_command
from hitab_client.run_folder import running_swarms
from hitab_core import Do, each_once, quantity, some

MANY = 100  # agents; a larger swarm takes long to ask
ASK_SECONDS = 3.0


def faults() -> Iterator[Finding]:
    """Report what agents say that hinders them, such as a silent sensor."""
    for _, record in running_swarms():
        if len(record.agents) > MANY:
            count = quantity(len(record.agents), "agent")
            told = f"the {count} of {record.swarm} were not asked; {as_command(Do.STATUS())}"
            yield Finding("agents", told)
        else:
            yield from _faults_of(record)


def _faults_of(record: RunRecord) -> Iterator[Finding]:
    with RosLink(record.domain_id) as link:
        agents = SwarmClient(
            link, record.agents, prefix=record.namespace, identity=record.identity
        )
        agents.watch_all()
        link.spin_until(lambda: len(agents.statuses) == len(record.agents), ASK_SECONDS)
        statuses = dict(agents.statuses)
    if mute := [name for name in record.agents if name not in statuses]:
        told = f"{some(mute)} of {record.swarm} did not answer within {ASK_SECONDS:g} s"
        yield warning("agents", told, as_command(Do.LOGS(node=mute[0])))
    found = list(told_by(statuses))
    yield from found
    if not mute and not found:
        yield Finding("agents", f"{quantity(len(statuses), 'agent')} of {record.swarm}: no faults")


def told_by(statuses: Mapping[str, AgentStatus]) -> Iterator[Finding]:
    """Report the faults of agents, each once with the names of those concerned."""
    for fault in each_once((name, fault) for name, s in statuses.items() for fault in s.faults):
        yield warning("agents", fault, as_command(Do.STATUS()))
