"""Concerns in what a swarm reports: pure functions of statuses, groups and signs of life."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping

from hitab_msgs.msg import AgentStatus, CommanderStatus, MachineStatus

from hitab_client.attention.items import Concern, Kind
from hitab_client.attention.stillness import Doing, Stuck
from hitab_core import Fix, Remedy, Term, natural, quantity, some
from hitab_ros import fault_texts
from hitab_ros.messages.conversions import remedies_of

Statuses = Mapping[str, AgentStatus]
Groups = Mapping[str, CommanderStatus]

MAJORITY = 0.8
"""Share of a domain's agents whose library is the usual one."""

BEHAVIORS_MAX = 3
"""Maximum number of behaviors that are proposed to replace those of a library."""

LEFT_TO_PERSON = (AgentStatus.TRAINING, AgentStatus.TESTING)
"""Modes in which a person cares for the agent already."""


def doings(statuses: Statuses, groups: Groups) -> dict[str, Doing]:
    """Return what each agent does that performs a behavior and may act, without commanders.

    A commander waits for what its members report, and has no position.
    """
    return {
        name: Doing(status.domain, status.behavior, tuple(status.active_path))
        for name, status in statuses.items()
        if status.mode == AgentStatus.PERFORMING and status.armed and name not in groups
    }


def superiors_of(statuses: Statuses, groups: Groups) -> dict[str, str]:
    """Return the commander of each agent and commander that has one."""
    found = {name: status.order.commander for name, status in statuses.items()}
    found |= {name: group.superior for name, group in groups.items()}
    found |= {member.name: name for name, group in groups.items() for member in group.subordinates}
    return {name: superior for name, superior in found.items() if superior}


def absent(
    silent: Mapping[str, float], missing: Collection[str], process_of: Callable[[str], str]
) -> Iterator[Concern]:
    """Yield the processes that are silent or that the world does not hear.

    Args:
        silent: names that give no signs of life, with the time since the last sign, s.
        missing: agents for which the world gets no answers.
        process_of: returns the process that runs an agent, or the agent's own name.
    """
    affected: dict[str, set[str]] = defaultdict(set)
    for name in {*silent, *missing}:
        affected[process_of(name)].add(name)
    for process, names in affected.items():
        seconds = min((silent[name] for name in names if name in silent), default=None)
        what = "does not answer the world" if seconds is None else "gives no signs of life"
        why = "the world goes on without it" if seconds is None else f"for {seconds:.0f} s"
        if names != {process}:
            why += f"; it runs {some(sorted(names, key=natural))}"
        ways = (Fix.LOGS(node=process),)
        yield Concern(Kind.SILENT, process, what, why, ways, len(names))


def machines(known: Mapping[str, MachineStatus], silent: Mapping[str, float]) -> Iterator[Concern]:
    """Yield the machines that are silent, have faults or are hardly heard by others."""
    for name, seconds in silent.items():
        agents = sum(len(process.agents) for process in known[name].processes)
        what = "this machine gives no signs of life"
        why = f"for {seconds:.0f} s; it ran {quantity(agents, 'agent')}"
        yield Concern(Kind.SILENT, name, what, why, (Fix.STATUS(),), max(1, agents))
    for name, status in known.items():
        if name not in silent:
            for fault in status.faults:
                yield Concern(Kind.FAULT, name, fault, remedies=(Fix.STATUS(),))


def faulty(statuses: Statuses) -> Iterator[Concern]:
    """Yield the agents with faults, other than that their robot may not act."""
    for name, status in statuses.items():
        faults = [fault for fault in status.faults if fault != status.stopped]
        if faults and not status.order.waits:
            what = faults[0].replace(name, "it")
            yield Concern(Kind.FAULT, name, what, "; ".join(faults), _ways(status))


def disobeying(statuses: Statuses, groups: Groups) -> Iterator[Concern]:
    """Yield the members that do not perform their commander's order, though they could."""
    for commander, group in groups.items():
        for member in group.subordinates:
            if member.obeys or member.silent or member.stopped or not group.order:
                continue
            status = statuses.get(member.name)
            if status is not None and status.mode in LEFT_TO_PERSON:
                continue
            does = member.behavior or "nothing"
            what = f"performs {does} instead of what {commander} orders, {group.order}"
            why, ways = "it obeys the next order", [Fix.TREE(commander=commander)]
            if status is not None:
                ordered = status.order.behavior
                ways = [Fix.PERFORM(agent=member.name, behavior=ordered or group.order)]
                if status.order.waits and status.last_error:
                    why, ways = status.last_error, [*_ways(status)]
            yield Concern(Kind.DISOBEYS, member.name, what, why, tuple(ways))


def stuck(statuses: Statuses, still: Mapping[str, Stuck]) -> Iterator[Concern]:
    """Yield the agents that get nowhere although their mates do."""
    for name, (seconds, usual) in still.items():
        status = statuses[name]
        doing = " > ".join((status.behavior, *status.active_path[:-1]))
        why = f"no change for {seconds:.0f} s; its mates go on after {usual:.0f} s"
        ways = (Fix.TRAIN_FURTHER(agent=name, behavior=status.behavior), Fix.PERFORM(agent=name))
        what = f"stuck in {doing}"
        yield Concern(Kind.STUCK, name, what, why, ways, teaches=status.behavior)


def unarmed(statuses: Statuses) -> Iterator[Concern]:
    """Yield the robots that wait for a person to arm them, with no cause left to stand still."""
    for name, status in statuses.items():
        if not status.armed and status.stopped.startswith(fault_texts.WAITS_TO_BE_ARMED):
            yield Concern(Kind.UNARMED, name, status.stopped, "", (Fix.ARM(robot=name),))


def unsure(statuses: Statuses) -> Iterator[Concern]:
    """Yield the agents that are unsure, or whose decisions are far from all examples."""
    for name, status in statuses.items():
        caution = status.caution
        if status.mode in LEFT_TO_PERSON or not (caution.unsure or caution.decided_at):
            continue
        why = caution.unsure or (
            f"recent decisions were {caution.decided_at:.2g} spreads of the examples from the "
            "nearest one"
        )
        what = f"decides far from all examples of {status.behavior}"
        ways = (
            Fix.TRAIN_FURTHER(agent=name, behavior=status.behavior),
            Fix.CAUTION(agent=name, when_unsure="halt"),
        )
        yield Concern(Kind.UNSURE, name, what, why, ways, teaches=status.behavior)


def differing(statuses: Statuses, groups: Groups) -> Iterator[Concern]:
    """Yield the agents whose libraries differ from that of most agents of their domain.

    Where most agents have libraries of their own, none differs. Which behavior differs is unknown;
    those that most of the mates perform bring all that they use.
    """
    domains: dict[str, list[AgentStatus]] = defaultdict(list)
    for name, status in statuses.items():
        if name not in groups:
            domains[status.domain].append(status)
    for mates in domains.values():
        (usual, count), *_ = Counter(mate.library_digest for mate in mates).most_common(1)
        if count == len(mates) or count < MAJORITY * len(mates):
            continue
        source = next(mate for mate in mates if mate.library_digest == usual)
        # A basic behavior has no states, and comes with the domain.
        trained = [mate.behavior for mate in mates if mate.active_path]
        performed = Counter(Term.parse(behavior).name for behavior in trained)
        behaviors = [behavior for behavior, _ in performed.most_common(BEHAVIORS_MAX)]
        for status in mates:
            if status.library_digest != usual:
                why = (
                    f"its library is {status.library_digest[:8]}; {count} of {len(mates)} agents "
                    f"have {usual[:8]}"
                )
                what = "has other behaviors than most"
                ways = tuple(
                    Fix.GIVE(agent=source.agent, behavior=behavior, receiver=status.agent)
                    for behavior in behaviors
                )
                yield Concern(Kind.LIBRARY, status.agent, what, why, ways)


def _ways(status: AgentStatus) -> tuple[Remedy, ...]:
    return tuple(remedies_of(status.remedies))
