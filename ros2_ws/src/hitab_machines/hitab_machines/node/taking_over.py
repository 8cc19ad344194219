"""Start of processes of other machines here, under a new lease."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

from hitab_msgs.msg import HostRoster
from hitab_msgs.srv import RunProcess

from hitab_bringup import SwarmDescription
from hitab_bringup.processes.leases import Leases
from hitab_bringup.processes.supervision import add_process
from hitab_client import RunFolder, RunRecord
from hitab_core import HitabError, has, load_domain, quantity, some
from hitab_machines.files.copies import Copies
from hitab_machines.files.learned_files import LearnedFiles
from hitab_machines.node.jobs import Jobs
from hitab_machines.process_holders import ProcessHolders, running
from hitab_ros import GuardedNode, names, qos
from hitab_ros.answering import what_went_wrong
from hitab_ros.call import SwarmError
from hitab_ros.names import WORLD
from hitab_ros.timing import DISCOVERY_S, FOUND_S, PROMPT_S, START_S

TAKE_OVER_AFTER_S = PROMPT_S + FOUND_S
"""Silence of a machine, s, after which others take its processes over, if the file says so."""

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
            lost.name: [m.name for m in swarm.machines if lost.name in m.takes_over]
            for lost in swarm.machines
        }
        self._robots = {a.name for a in swarm.agents if load_domain(a.domain).link}
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
        """Take the roster of a host: a newer lease elsewhere ends that of this machine."""
        process, record = self._process_of.get(next(iter(roster.agents), "")), self._record
        if process is None or roster.swarm != record.identity:
            return
        if roster.machine == record.machine:
            self._rosters[process] = roster
        elif roster.machine in record.machines and self._is_here(process):
            own = self._leases.of(process)
            newer = (roster.lease, record.machine) > (own, roster.machine)
            if newer and roster.lease <= own + LEASE_AHEAD_MAX:
                self._leases.give_up(process, roster.lease)

    def look(self, silent: Mapping[str, float]) -> None:
        """Take over the processes of machines that are lost, if the swarm file says so."""
        own, others = self._record.machine, {*self._record.machines} - {self._record.machine}
        reached = {own} | {name for name in others if name in self._signs.heard} - silent.keys()
        # The smaller part of a network that is divided leaves everything to the larger one.
        if 2 * len(reached) < len(self._record.machines):
            return
        for lost, seconds in silent.items():
            able = reached.intersection(self._rescuers.get(lost, ()))
            if seconds < TAKE_OVER_AFTER_S or own != min(able, default=""):
                continue
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
        if self._is_here(process):
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

    async def _start(self, process: str, lease: int) -> list[str]:
        owner, claimed_ns = self._holders.holder(process), time.time_ns()
        lost = [*await self._claim(process, lease, owner), *await self._bring(process, owner)]
        if owner:
            lost += self._learned.install(process, self._copies.of(owner), self._is_here)
        self._leases.take(process, lease)
        add_process(self._folder, self._record, process, lease)

        def is_up() -> bool:
            roster = self._rosters.get(process)
            return roster is not None and roster.lease == lease and roster.number > claimed_ns

        if not await self._jobs.until(is_up, START_S):
            raise SwarmError(
                f"{process} did not start on {self._record.machine}: "
                f"{' '.join(self._folder.tail(process, 1))} (log: {self._folder.log(process)})"
            )
        return lost

    async def _claim(self, process: str, lease: int, owner: str) -> list[str]:
        """Have the host on another machine yield; return what may be lost."""
        if owner not in self._signs.heard:
            return []
        agents, machine = self._record.processes[process], self._record.machine
        topic = names.of_swarm(names.HOSTS, self._record.namespace)
        publisher = self._node.create_publisher(HostRoster, topic, qos.LATCHED, temporary=True)

        def has_yielded() -> bool:
            status = self._signs.heard[owner].status
            return owner in self._signs.silent() or process not in running(status)

        try:
            publisher.publish(
                HostRoster(
                    host=names.of_host(agents[0], machine),
                    number=time.time_ns(),
                    agents=agents,
                    machine=machine,
                    lease=lease,
                    swarm=self._record.identity,
                )
            )
            if await self._jobs.until(has_yielded, DISCOVERY_S):
                return []
            return [f"{owner} did not end {process}; what its agents learn from now on is lost"]
        finally:
            # The host that starts here would take the claim for another one.
            self._node.destroy_publisher(publisher)

    async def _bring(self, process: str, owner: str) -> list[str]:
        """Copy what the agents of a process have learned; return what may be lost."""
        if not owner:
            return ["no machine is known to have it: it begins with what is here"]
        silence = self._signs.silent().get(owner)
        if silence is None and owner in self._signs.heard:
            try:
                await self._copies.bring(owner, self._learned.is_of(process))
                return []
            except SwarmError as error:
                why = error.problem
        else:
            why = f"{owner} is silent" + ("" if silence is None else f" for {silence:.0f} s")
        age = self._copies.age(owner)
        if age is None:
            return [f"{why}, and there is no copy of its files: {process} begins untrained"]
        return [f"{why}, and its copy is {age:.0f} s old: what was learned since then is lost"]


def _job(process: str) -> str:
    return f"start of {process}"
