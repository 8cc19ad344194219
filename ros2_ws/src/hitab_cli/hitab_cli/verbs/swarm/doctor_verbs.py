"""Verb that looks for problems: doctor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated

import typer

from hitab_bringup.doctor import ERROR, WARNING, Finding
from hitab_client import console
from hitab_client.connecting.ros_environment import problems
from hitab_client.terminal.cli_options import JsonPath
from hitab_core import HitabError, quantity, some

Network = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS", min=1.0, help="Also listen so long to other computers that do the same."
    ),
]

STYLES = {"ok": "", "warning": "yellow", "error": "bold red"}


def doctor(json: JsonPath = None, network: Network = None) -> None:
    """Check this computer, ROS, DDS, and running swarms; name each problem and its remedy.

    The exit status is 1 if there is an error.

    Example:
      hitab doctor
      hitab doctor --network 10    # on each computer, at the same time
    """
    found = []
    for finding in _findings(network):
        found.append(finding)
        if json != "-":
            line = f"{finding.level:7} {finding.about:14} {finding.text}"
            line += f"\n{'':22} {finding.way_out}" if finding.way_out else ""
            console.out().print(console.line(line, STYLES[finding.level]))
    counts = {level: sum(f.level == level for f in found) for level in STYLES}
    summary = f"{quantity(counts['error'], 'error')}, {quantity(counts['warning'], 'warning')}"
    summary = summary if counts["error"] or counts["warning"] else "no problems found"
    console.show(json, [asdict(finding) for finding in found], summary)
    if counts["error"]:
        raise typer.Exit(1)


def _findings(network: float | None) -> Iterator[Finding]:
    from hitab_bringup.doctor import machine, ros, runs

    yield from machine.python()
    # If ROS cannot start, it may end the process that loads it.
    starts = [Finding(about, text, ERROR, way) for about, text, way in problems()] or [
        *ros.installation(),
        *ros.middleware(),
        *ros.domain(),
    ]
    yield from starts
    yield from runs.swarms()
    yield from runs.leftovers()
    if all(finding.level != "error" for finding in starts):
        try:
            yield from runs.faults()
            yield from _machines()
        except HitabError as refused:
            yield Finding("ROS", str(refused), ERROR, "check the variables that begin with ROS_")
    if network is not None and all(finding.level != "error" for finding in starts):
        from hitab_cli.verbs.swarm.network_check import network as check_network

        yield from check_network(network)
    yield from machine.home()
    yield from machine.memory()
    yield from machine.limits()


def _machines() -> Iterator[Finding]:
    """Yield what is wrong with the machines of swarms that are up."""
    from hitab_client import RosLink
    from hitab_client.runs.run_folder import running_swarms
    from hitab_machines import SwarmMachines

    for _, record in running_swarms():
        if not record.machines:
            continue
        with RosLink(record.domain_id) as link:
            machines = SwarmMachines(link, record)
            machines.listen()
            for name in machines.silent():
                yield Finding(record.swarm, f"{name} {machines.why_silent(name)}", ERROR)
            for fault, telling in machines.faults().items():
                yield Finding(record.swarm, f"{fault} (says {some(telling)})", WARNING)
