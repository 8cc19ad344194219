"""Start of processes of other machines here, under a new lease."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from hitab_msgs.msg import Alive, HostRoster, MachineStatus
from hitab_msgs.srv import RunProcess

from hitab_bringup import SwarmDescription
from hitab_bringup.processes.leases import Leases
from hitab_bringup.processes.supervision import add_process
from hitab_client import RunFolder, RunRecord
from hitab_core import HitabError, has, load_domain, quantity, some
from hitab_machines.files.copies import Copies
from hitab_machines.files.learned_files import LearnedFiles
from hitab_machines.node.jobs import Jobs
from hitab_machines.node.lost_machines import to_take_over
from hitab_machines.process_holders import ENDED, RUNNING, ProcessHolders, running
from hitab_ros import GuardedNode, Lease, names, qos
from hitab_ros.answering import what_went_wrong
from hitab_ros.call import SwarmError, turn
from hitab_ros.names import WORLD
from hitab_ros.timing import (
    AT_ONCE_S,
    DISCOVERY_S,
    HEARTBEAT_S,
    SILENT_AFTER_S,
    START_S,
)

LEASE_AHEAD_MAX = 1000
"""Maximum lead of a lease over the newest known one: leases count moves, and must not run out."""


@dataclass
class StartOutcome:
    """What came of a request to start a process; empty texts while it is under way."""

    message: str = ""
    error: str = ""
    lost: list[str] = field(default_factory=list)


class TakingOver:
    """Starts processes of other machines on this one.

    First it claims the process by a roster with the new lease, so that the host on the other
    machine yields and nothing changes there any more. Then it brings what the agents have learned.

    Args:
        node: the node of this machine.
        holders: which machine has which process.
        folder: run folder of the swarm here.
        record: record of the run.
        swarm: the swarm's description.
        jobs: runs the starts.
        leases: the leases of this machine.
        copies: the copies of the other machines' files.
    """

    def __init__(
        self,
        node: GuardedNode,
        holders: ProcessHolders,
        folder: RunFolder,
        record: RunRecord,
        swarm: SwarmDescription,
        jobs: Jobs,
        leases: Leases,
        copies: Copies,
    ) -> None:
        self._holders, self._signs = holders, holders.signs
        self._jobs, self._leases, self._copies = jobs, leases, copies
        self._folder, self._record = folder, record
        self._learned = LearnedFiles(swarm, folder.path)
        self._rescuers = {
            lost.name: {m.name for m in swarm.machines if lost.name in m.takes_over}
            for lost in swarm.machines
        }
        # A domain takes 13 ms to load, and a thousand agents have few.
        links = {name: load_domain(name).link for name in {a.domain for a in swarm.agents}}
        self._robots = {a.name for a in swarm.agents if links[a.domain]}
        self._process_of = {name: p for p, agents in record.processes.items() for name in agents}
        self._outcomes: dict[tuple[str, int], StartOutcome] = {}
        self._rosters: dict[str, HostRoster] = {}
        self._node = node

    def serve(
        self, request: RunProcess.Request, response: RunProcess.Response
    ) -> RunProcess.Response:
        """Begin to run a process, or return what came of it; the message is empty until then."""
        process, lease = request.process, request.lease
        outcome = self._outcomes.get((process, lease)) or self._begin(process, lease)
        if outcome.error:
            raise HitabError(outcome.error)
        response.success, response.message = True, outcome.message
        response.lost = outcome.lost
        return response

    def hear(self, roster: HostRoster) -> None:
        """Take the roster of a living host: a newer lease elsewhere ends that of this machine."""
        process, record = self._process_of.get(next(iter(roster.agents), "")), self._record
        if process is None or roster.swarm != record.identity:
            return
        if roster.machine == record.machine:
            self._rosters[process] = roster
        elif roster.machine in record.machines and self._is_here(process):
            own = Lease(record.machine, self._leases.of(process))
            is_newer = Lease(roster.machine, roster.lease).rank < own.rank
            if is_newer and roster.lease <= own.number + LEASE_AHEAD_MAX:
                self._leases.give_up(process, roster.lease)
                self._node.get_logger().warning(
                    f"{process} runs on {roster.machine} now (lease {roster.lease}); what its "
                    f"agents have learned here since the last copy stays in {self._folder.path}"
                )

    def look(self, silent: Mapping[str, float]) -> None:
        """Take over the processes of machines that are lost, if the swarm file says so."""
        hears = {name: {*_heard(heard.status)} for name, heard in self._signs.heard.items()}
        for lost in to_take_over(self._record.machine, self._rescuers, silent, hears):
            for process in running(self._signs.heard[lost].status):
                lease = self._holders.newest_lease(process) + 1
                is_free = self._holders.holder(process) == lost and not self._robots_in(process)
                is_new = (process, lease) not in self._outcomes
                if is_free and is_new and not self._jobs.is_running(_job(process)):
                    self._begin(process, lease)

    def _robots_in(self, process: str) -> list[str]:
        return sorted(self._robots.intersection(self._record.processes[process]))

    def _is_here(self, process: str) -> bool:
        own = process in (*self._record.processes_here, *self._leases.taken)
        return own and not self._leases.is_yielded(process)

    def _begin(self, process: str, lease: int) -> StartOutcome:
        self._check(process, lease)
        self._outcomes = {key: o for key, o in self._outcomes.items() if key[0] != process}
        outcome = self._outcomes[process, lease] = StartOutcome()
        self._jobs.start(_job(process), self._run(process, lease, outcome))
        return outcome

    def _check(self, process: str, lease: int) -> None:
        """Check that a process can be started here under a lease.

        Raises:
            HitabError: if it cannot.
        """
        here, inside = self._record.machine, self._record.processes
        movable = [name for name, agents in inside.items() if agents]
        if process == WORLD:
            raise HitabError(
                f"{WORLD} stays on {self._holders.holder(process)}: it has no lease, so that "
                "two might run; name another machine in the swarm file, and start the swarm again"
            )
        if process not in movable:
            raise HitabError(f'no process "{process}" has agents {has(movable, process)}')
        if robots := self._robots_in(process):
            raise HitabError(
                f"{process} stays on {self._holders.holder(process)}: "
                f"{some(robots)} {'drives a robot' if len(robots) == 1 else 'drive robots'} there"
            )
        if self._jobs.is_running(_job(process)):
            raise HitabError(f"{process} is just being started on {here}; ask again in a moment")
        if self._is_here(process) and self._holders.state(process, here) != ENDED:
            raise HitabError(f"{process} runs on {here} already")
        known = self._holders.newest_lease(process)
        if not known < lease <= known + LEASE_AHEAD_MAX:
            raise HitabError(
                f"the lease {lease} of {process} is not the next after {known}, the newest one of "
                f"{self._holders.holder(process)}; look with `hitab status`, and ask again"
            )

    async def _run(self, process: str, lease: int, outcome: StartOutcome) -> None:
        try:
            outcome.lost = await self._start(process, lease)
        except Exception as error:
            outcome.error = what_went_wrong(error)
            raise
        agents = self._record.processes[process]
        outcome.message = (
            f"{process} with {quantity(len(agents), 'agent')} runs on {self._record.machine} now "
            f"(lease {lease})"
        )
        self._node.get_logger().info("; ".join([outcome.message, *outcome.lost]))

    async def _start(self, process: str, lease: int) -> list[str]:
        owner, lost = self._holders.holder(process), list[str]()
        # Two machines that both cannot start it would give it back to each other for ever.
        it_ran = self._holders.state(process, owner) == RUNNING
        try:
            if owner != self._record.machine:  # else nobody has learned anything since
                lost += await self._claim(process, lease, owner)
                lost += await self._bring(process, owner)
            await self._host(process, lease)
        except Exception as error:
            raise SwarmError(
                f"{what_went_wrong(error)}; {await self._give_back(process, lease, owner, it_ran)}"
            ) from error
        return lost

    async def _host(self, process: str, lease: int) -> None:
        """Start the host under a lease that is claimed, and wait until it lives."""
        began_ns = time.time_ns()  # the claim was before
        self._leases.take(process, lease)
        add_process(self._folder, self._record, process, lease)

        def is_up() -> bool:
            roster = self._rosters.get(process)
            return roster is not None and roster.lease == lease and roster.number > began_ns

        if not await self._jobs.until(is_up, START_S):
            raise SwarmError(
                f"{process} did not start on {self._record.machine}: "
                f"{' '.join(self._folder.tail(process, 1))} (log: {self._folder.log(process)})"
            )

    async def _give_back(self, process: str, lease: int, owner: str, it_ran: bool) -> str:
        """Have the machine that had a process start it again; return what came of it."""
        if not it_ran or owner in self._signs.silent():
            return f"{process} runs nowhere: `hitab move {process} --to MACHINE` tries again"
        request = RunProcess.Request(process=process, lease=lease + 1)
        try:
            return await self._ask_to_run(owner, request)
        except SwarmError as error:
            return f"{owner} does not take {process} back: {error.problem}"

    async def _ask_to_run(self, machine: str, request: RunProcess.Request) -> str:
        """Have another machine run a process, and wait until it does; return what it says."""
        service = names.of_agent(machine, names.RUN_PROCESS, self._record.namespace)
        while True:
            answer = await self._jobs.call.coroutine(
                RunProcess,
                service,
                request,
                missing=lambda: SwarmError(f"the machine {machine} does not answer"),
                where=machine,
            )
            if answer.message:
                return str(answer.message)
            await turn(HEARTBEAT_S)

    async def _claim(self, process: str, lease: int, owner: str) -> list[str]:
        """Have the host on another machine yield; return what may be lost."""
        if owner not in self._signs.heard:
            return []
        record, agents = self._record, self._record.processes[process]
        host = names.of_host(agents[0], record.machine)
        hosts, alive = (
            names.of_swarm(name, record.namespace) for name in (names.HOSTS, names.ALIVE)
        )
        rosters = self._node.create_publisher(HostRoster, hosts, qos.LATCHED, temporary=True)
        signs = self._node.create_publisher(Alive, alive, qos.SIGNS_OF_LIFE, temporary=True)

        def is_free() -> bool:
            is_silent = owner in self._signs.silent()
            return is_silent or self._holders.has_yielded(process, owner, lease)

        try:
            rosters.publish(
                HostRoster(
                    host=host,
                    number=time.time_ns(),
                    agents=agents,
                    machine=record.machine,
                    lease=lease,
                    swarm=record.identity,
                )
            )
            # A roster alone stops no host.
            sign = Alive(process=host, swarm=record.identity)
            if await self._jobs.repeat(
                lambda: signs.publish(sign), is_free, DISCOVERY_S, AT_ONCE_S
            ):
                return []
            return [f"{owner} did not end {process}; what its agents learn from now on is lost"]
        finally:
            # The host that starts here would take the claim for another one.
            self._node.destroy_publisher(rosters)
            self._node.destroy_publisher(signs)

    async def _bring(self, process: str, owner: str) -> list[str]:
        """Install what the agents of a process have learned; return what may be lost."""
        if not owner:
            return ["no machine is known to have it: it begins with what is here"]
        lost = await self._copy(process, owner)
        return [*lost, *self._learned.install(process, self._copies.of(owner), self._is_here)]

    async def _copy(self, process: str, owner: str) -> list[str]:
        """Copy what the agents of a process have learned; return what may be lost."""
        silence = self._signs.silent().get(owner)
        if silence is None and owner in self._signs.heard:
            try:
                await self._copies.bring(owner, self._learned.is_of(process))
                return []
            except HitabError as error:
                why = error.problem
        else:
            why = f"{owner} is silent" + ("" if silence is None else f" for {silence:.0f} s")
        age = self._copies.age(owner)
        if age is None:
            return [f"{why}, and there is no whole copy of its files: {process} begins untrained"]
        missing = self._copies.missing(owner, self._learned.is_of(process))
        return [
            f"{why}, and its copy is {age:.0f} s old: what was learned since then is lost",
            *(f"{path} is missing from the copy: what it keeps is lost" for path in missing),
        ]


def _heard(status: MachineStatus) -> Iterator[str]:
    """Yield the machines that a machine hears."""
    return (link.machine for link in status.links if link.age < SILENT_AFTER_S)


def _job(process: str) -> str:
    return f"start of {process}"
