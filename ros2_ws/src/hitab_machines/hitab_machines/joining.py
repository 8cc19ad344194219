"""Joining of a machine to its swarm: what it must have in common with the others."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator

from hitab_msgs.msg import MachineStatus

from hitab_bringup import SwarmDescription, description_digest
from hitab_client import MachineSigns, RosLink, RunRecord, SwarmError, domain_ids
from hitab_client.connecting.dds_profile import RANGE, is_of_this_machine
from hitab_client.terminal.cli_remedies import called
from hitab_core import installed_version, some
from hitab_machines.process_holders import running
from hitab_ros.timing import DISCOVERY_S, FOUND_S, SILENT_AFTER_S

Progress = Callable[[int, int, str], None]
"""Called with the number of machines that are up, their number and the names of the others."""


def refuse_limits(swarm: str) -> None:
    """Check that messages reach other machines.

    Args:
        swarm: name of the swarm.

    Raises:
        SwarmError: if discovery is limited to this machine; names the variable.
    """
    if is_of_this_machine(os.environ):
        raise SwarmError(
            f"swarm {swarm} has to reach other machines, but the messages of this terminal stay "
            f"on this one; `export {RANGE}=SUBNET` on each machine before `{called()} up`"
        )


def refuse_to_join(swarm: SwarmDescription) -> None:
    """Check that the machines that are up have the same swarm, and that none is this one.

    Raises:
        SwarmError: otherwise; names the machines and the difference.
    """
    refuse_limits(swarm.name)
    with _signs_of(swarm, domain_ids.for_swarm(is_free=False)) as (link, signs):
        expected = {machine.name for machine in swarm.machines} - {swarm.machine}

        def is_up() -> bool:
            """Whether this machine is heard, here or by others, which may be found first."""
            links = [link for one in signs.heard.values() for link in one.status.links]
            return swarm.machine in signs.heard or any(
                link.machine == swarm.machine and link.age < SILENT_AFTER_S for link in links
            )

        link.spin_until(
            lambda: (
                swarm.machine in signs.heard or (expected <= signs.heard.keys() and not is_up())
            ),
            FOUND_S,
        )
        statuses = {name: machine.status for name, machine in signs.heard.items()}
        taken = is_up()
    if taken:
        others = some([name for name in expected if name not in statuses]) or "none"
        raise SwarmError(
            f"{swarm.machine} of swarm {swarm.name} is already up, on another computer or in "
            f"another run folder; take it down there, or start another here (not up: {others})"
        )
    for text in _differences(swarm, statuses):
        raise SwarmError(text)


def await_machines(
    swarm: SwarmDescription, record: RunRecord, progress: Progress
) -> Iterator[str]:
    """Wait a while for the other machines; yield sentences about those that are missing or differ.

    Args:
        swarm: the description, with this machine.
        record: the record of this machine's part, which is up.
        progress: called as machines are heard.
    """
    with _signs_of(swarm, record.domain_id) as (link, signs):

        def missing() -> list[str]:
            names = [name for name in record.machines if name != record.machine]
            names = [name for name in names if name not in signs.heard]
            progress(len(record.machines) - len(names), len(record.machines), some(names))
            return names

        link.spin_until(lambda: not missing(), DISCOVERY_S)
        left = missing()
        statuses = {name: machine.status for name, machine in signs.heard.items()}
    if left:
        yield (
            f"not up yet: {some(left)}; start each on its computer, as with `{called()} up "
            f"{swarm.name} --machine {left[0]}`, which gets the swarm file from here"
        )
    for name, status in statuses.items():
        moved = [it for it in running(status) if it in record.machines[record.machine]]
        if moved and name != record.machine:
            yield (
                f"{name} runs {some(moved)} now; `{called()} move {moved[0]} --to "
                f"{record.machine}` moves it back"
            )
    yield from _differences(swarm, statuses)


def _differences(swarm: SwarmDescription, statuses: dict[str, MachineStatus]) -> Iterator[str]:
    own, version = description_digest(swarm), installed_version()
    for name, status in statuses.items():
        if name != swarm.machine and status.description != own:
            versions = "" if status.version == version else f" of HiTAB {status.version}"
            here = f" of HiTAB {version}" if versions else ""
            way = (
                "install the same version on both"
                if versions
                else f"copy the files from one to the other, or have them sent: `{called()} up "
                f"{swarm.name} --machine {swarm.machine}`, where no file is called {swarm.name}"
            )
            yield (
                f"{name} runs another description of swarm {swarm.name} (digest "
                f"{status.description}{versions}) than {swarm.machine} (digest {own}{here}); {way}"
            )


@contextlib.contextmanager
def _signs_of(swarm: SwarmDescription, domain_id: int) -> Iterator[tuple[RosLink, MachineSigns]]:
    with RosLink(domain_id) as link:
        yield link, MachineSigns(link.node, swarm.namespace, swarm.identity())
