"""The node of a machine: its signs, what it shares, and what it does for the others."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from typing import Any

from hitab_msgs.msg import MachineFile, MachineStatus
from hitab_msgs.srv import ReadFiles, ReadLog, RunProcess
from std_srvs.srv import Trigger

from hitab_bringup import SwarmDescription, described_files, description_digest
from hitab_bringup.processes.leases import Leases
from hitab_client import DescriptionError, MachineSigns, RunFolder, RunRecord
from hitab_client.runs.run_folder import MARK
from hitab_core import HitabError, installed_version, some
from hitab_machines.files.copies import Copies, copied_folders
from hitab_machines.files.shared_files import SharedFiles
from hitab_machines.node.faults import MachineFaults
from hitab_machines.node.jobs import Jobs
from hitab_machines.node.local_processes import LocalProcesses
from hitab_machines.node.taking_over import TakingOver
from hitab_machines.process_holders import ProcessHolders
from hitab_ros import GuardedNode, HostRosters, names, steady_timer
from hitab_ros.timing import REPEAT_S, UPDATE_S

NODE = "machine"

LISTING_FACTOR = 100
"""Time between two looks for changed files, in durations of a look: a hundredth of a core."""


class MachineNode(GuardedNode):
    """A machine of a swarm, for the other machines and for people.

    Args:
        folder: run folder of the swarm here.
        record: record of the run.
        swarm: the swarm's description.
        options: see `rclpy.node.Node`.

    Attributes:
        signs: the signs of the other machines.
        status: the last status of this machine.
    """

    def __init__(
        self, folder: RunFolder, record: RunRecord, swarm: SwarmDescription, **options: Any
    ) -> None:
        prefix, machine = record.namespace, record.machine
        super().__init__(NODE, namespace=f"{prefix}/{machine}", **options)
        self._began, self._look_at = time.monotonic(), 0.0
        self._folder, self._record = folder, record
        jobs, leases = Jobs(self), Leases(folder.path)
        self._jobs = jobs
        self._processes = LocalProcesses(folder, record, leases)
        described = _described(swarm)
        self._shared = {
            ReadFiles.Request.RUN: copied_folders(folder.path),
            ReadFiles.Request.DESCRIPTION: described,
        }
        self._described = described.digests()
        self.status = MachineStatus(
            machine=machine,
            version=installed_version(),
            description=description_digest(swarm),
        )
        self._differing: dict[int, str] = {}
        self.signs = MachineSigns(self, prefix, record.identity, machine, self._fill)
        self._copies = Copies(folder.path / "copies", jobs, prefix)
        self._faults = MachineFaults(self.signs, machine, list(record.machines))
        holders = ProcessHolders(self.signs, record, lambda: self.status)
        self._taking_over = TakingOver(
            self, holders, folder, record, swarm, jobs, leases, self._copies
        )
        self.create_service(ReadFiles, names.READ_FILES, self._read_files)
        self.create_service(ReadLog, names.READ_LOG, self._read_log)
        self.create_service(RunProcess, names.RUN_PROCESS, self._taking_over.serve)
        self.create_service(Trigger, names.TAKE_DOWN, self._take_down)
        hosts = names.of_swarm(names.HOSTS, prefix)
        rosters = HostRosters(self, hosts, lambda one: one.swarm == record.identity, leases=True)
        rosters.changed.append(self._taking_over.hear)
        steady_timer(self, UPDATE_S, self._look)

    def _fill(self, status: MachineStatus) -> None:
        """Complete the next status."""
        status.version, status.description = self.status.version, self.status.description
        status.files = self._token()
        status.processes = self._processes.statuses()
        faults = self._faults.found(self.status, time.monotonic() - self._began, self._differing)
        status.faults = [*faults, *self.guard.faults.texts()]
        self.status = status

    def _token(self) -> str:
        """Return a text that changes with this machine's files, looked at now and then."""
        now = time.monotonic()
        if now > self._look_at:
            self.status.files = self._shared[ReadFiles.Request.RUN].token()
            took = time.monotonic() - now
            self._look_at = now + max(REPEAT_S, LISTING_FACTOR * took)
        return str(self.status.files)

    def _look(self) -> None:
        """Follow the other machines: copy their files, compare them, and replace lost ones."""
        silent = self.signs.silent()
        for name, machine in self.signs.heard.items():
            if name in silent or name == self._record.machine or name not in self._record.machines:
                continue
            if machine.status.files:
                self._copies.follow(name, machine.status.files)
            if machine.status.process not in self._differing:
                self._jobs.start(
                    f"comparison with {name}", self._compare(name, machine.status.process)
                )
        self._taking_over.look(silent)

    async def _compare(self, machine: str, process: int) -> None:
        """Note which of the described files differ on a machine."""
        there = {
            file.path: file.digest
            for file in await self._copies.read(machine, ReadFiles.Request.DESCRIPTION)
        }
        paths = sorted(there.keys() | self._described.keys())
        differing = [path for path in paths if there.get(path) != self._described.get(path)]
        self._differing[process] = some(differing) if differing else ""

    def _read_files(
        self, request: ReadFiles.Request, response: ReadFiles.Response
    ) -> ReadFiles.Response:
        shared = self._shared.get(request.kind)
        if shared is None:
            raise HitabError(f'"{request.kind}" is no kind of files; use {some([*self._shared])}')
        response.files = (
            shared.read(request.paths)
            if request.paths
            else [MachineFile(path=path, digest=d) for path, d in shared.digests().items()]
        )
        response.success = True
        return response

    def _read_log(self, request: ReadLog.Request, response: ReadLog.Response) -> ReadLog.Response:
        response.lines, response.position = self._processes.log(
            request.process, request.position, request.lines
        )
        response.success = True
        return response

    def _take_down(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """End all processes of this run folder, by a process that is none of them."""
        environment = {name: value for name, value in os.environ.items() if name != MARK}
        command = [sys.executable, "-m", "hitab_machines.take_down_main", str(self._folder.path)]
        subprocess.Popen(command, env=environment, start_new_session=True, cwd="/")
        response.message = f"{self._record.machine} is being taken down"
        response.success = True
        return response


def _described(swarm: SwarmDescription) -> SharedFiles:
    """Return the files that describe a swarm; none if some are programs, which are not sent."""
    try:
        return SharedFiles(described_files(swarm))
    except DescriptionError:
        return SharedFiles({})
