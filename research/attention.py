"""Measures how fast one person finds and mends faults among a thousand robots.

A swarm of foragers under commanders plays in real time, in several hosts. Ten faults of five kinds
are planted at random squads and hosts, by the operations and files that any person has. A
simulated operator then takes the first item of the ranking (`hitab attention`), looks at it
(0.9 s, also if it is a false alarm) and corrects it (1.5 s, and the time that the correction
takes). All is real but the person: the reports, the corrections, and what they change.

Without the ranking, he looks at one after the other in random order, as the tree shows them: at
squads, supposing that a look shows all that is wrong with a member, or at agents, which is what
finding an agent that stands or decides strangely takes. His faults are the same, in the same
places, and visible at once; his corrections take as long. That is computed, for 1,000 orders.

    scripts/python research/attention.py --agents 50 --seeds 1
    scripts/python research/attention.py --seeds 3
"""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import typer

LOOK_S, CORRECTION_S = 0.9, 1.5
LIMIT_S = 300.0
WARM_UP_S, HEALTHY_S = 75.0, 60.0
SQUAD, MEMBERS_MAX = 5, 3
BESIDE_M = 0.8
ORDERS = 1000

SHIPPED = Path(__file__).parents[1] / "ros2_ws/src/foraging_world"


@dataclass(frozen=True)
class Fault:
    """A planted fault.

    Attributes:
        kind: what is wrong.
        names: the agents concerned, or the host.
        agents: the agents concerned.
        squads: the squads in which it shows.
    """

    kind: str
    names: frozenset[str]
    agents: frozenset[str]
    squads: frozenset[str]


@dataclass
class Run:
    """What the operator has done.

    Attributes:
        found: kind of item and time of each mended fault, by the fault.
        looks, corrections: their numbers.
        false: items that were no planted fault.
        seconds, correcting_s: time of all, and that of the corrections.
    """

    found: dict[Fault, tuple[str, float]] = field(default_factory=dict)
    looks: int = 0
    corrections: int = 0
    false: list[str] = field(default_factory=list)
    seconds: float = 0.0
    correcting_s: float = 0.0


def description(agents: int, hosts: int, seed: int) -> str:
    """Return the swarm file of foragers in squads, companies of five squads, and a chief."""
    squads, side = agents // SQUAD, 60.0 * (agents / 50.0) ** 0.5
    companies = max(1, squads // 5)
    return "\n".join(
        (
            "swarm: attention",
            "domain: foraging",
            f"start_from: {SHIPPED}/libraries/foraging",
            f"hosts: {hosts}",
            f"world: {{kind: foraging, pace: realtime, seed: {seed}, parameters: {{",
            f"  foragers: {agents}, width: {side:.0f}.0, height: {side:.0f}.0, duration: 3600.0,",
            f"  obstacles: {agents // 4}, small_boxes: {agents // 5},",
            f"  large_boxes: {agents // 25}}}}}",
            f"agents: {{forager: {{count: {agents}}}}}",
            "kinds:",
            f"  Squad: {SHIPPED}/libraries/foraging_squad/commander.yaml",
            f"  Company: {SHIPPED}/libraries/foraging_company/commander.yaml",
            "  Chief: {orders: {Forage: CompanyForage, GiveUp: GiveUp}}",
            "commanders:",
            f"  squad: {{kind: Squad, commands: {{forager: {SQUAD}}}, "
            f"start_from: {SHIPPED}/libraries/foraging_squad}}",
            f"  company: {{kind: Company, commands: {{squad: {squads // companies}}}, "
            f"start_from: {SHIPPED}/libraries/foraging_company}}",
            f"  chief: {{kind: Chief, commands: {{company: {companies}}}, behavior: Forage}}",
        )
    )


# -- planting -----------------------------------------------------------------------------------


def library(folder: Path, name: str, edit: Callable[[str], str]) -> Path:
    """Return a copy of the shipped library in which one behavior is edited."""
    shutil.copytree(SHIPPED / "libraries/foraging", folder)
    file = folder / f"{name}.hfa.yaml"
    file.write_text(edit(file.read_text(encoding="utf-8")), encoding="utf-8")
    return folder


def idle_search(text: str) -> str:
    """Return a Search that stands wherever the right one walks."""
    return re.sub(r"\bForward\b", "Stop", text)


def narrow_search(text: str) -> str:
    """Return a Search that was shown only where an obstacle is close ahead."""
    return re.sub(
        r"features: \[ *([-0-9.]+)\]",
        lambda found: f"features: [{0.01 * float(found[1]):.6f}]",
        text,
    )


def older_carry(text: str) -> str:
    """Return a Carry without its last example, as an older version had it."""
    lines = text.split("\n")
    last = max(i for i, line in enumerate(lines) if line.startswith("  - {number"))
    return "\n".join(lines[:last] + lines[last + 1 :])


WRONG_LIBRARIES = {
    "stands": ("Search", idle_search),
    "decides far from examples": ("Search", narrow_search),
    "older library": ("Carry", older_carry),
}


class Swarm:
    """The swarm that is up, with the operator's connection to it."""

    def __init__(self, swarm: Any, run_folder: Any, link: Any, place: Path) -> None:
        from hitab_client import SwarmClient, WorldClient
        from hitab_client.attention import AttentionListener
        from hitab_client.runs.run_processes import RunProcesses

        record = run_folder.read()
        self.place = place
        self.link = link
        self.processes = RunProcesses(record)
        of_it = {"identity": record.identity, "processes": self.processes}
        self.agents = SwarmClient(link, record.agents, **of_it)
        self.world = WorldClient(link, started_by_it=True, **of_it)
        self.agents.await_agents()
        self.world.wait()
        self.listener = AttentionListener(self.agents, self.world, has_world=True)
        self.squads = {
            commander.name: [
                member.name for member in swarm.agents if member.superior == commander.name
            ]
            for commander in swarm.commanders
        }
        self.squads = {name: members for name, members in self.squads.items() if members}
        self.hosts = {
            process: names for process, names in record.processes.items() if len(names) > 1
        }
        self._discover_at = 0.0

    def listen(self, seconds: float) -> list[Any]:
        """Spin for a while as the operator's program does; return the items afterwards."""
        end = time.monotonic() + seconds
        while True:
            if time.monotonic() >= self._discover_at:
                self.listener.discover()
                self._discover_at = time.monotonic() + 2.0
            items = self.listener.look()
            if (left := end - time.monotonic()) <= 0.0:
                return list(items)
            self.link.spin_until(lambda: False, min(left, 0.1))

    def plant(self, faults: int, dice: random.Random) -> list[Fault]:
        """Plant faults of five kinds, each in squads of its own."""
        five = ("silent host", "disobeys", *WRONG_LIBRARIES)
        # Hosts come last, since one that stands still for long is started again.
        kinds = [five[i % len(five)] for i in reversed(range(faults))]
        kinds.sort(key=lambda kind: kind == "silent host")
        with_agents = [h for h, names in self.hosts.items() if {*names} & {*self.agents.statuses}]
        away = dice.sample(with_agents, min(kinds.count("silent host"), len(with_agents) - 1))
        left = [
            squad
            for squad, members in self.squads.items()
            if not any({squad, *members} & {*self.hosts[host]} for host in away)
        ]
        dice.shuffle(left)
        return [
            self._plant(kind, away, left, dice) for kind in kinds if kind != "silent host" or away
        ]

    def _plant(self, kind: str, away: list[str], left: list[str], dice: random.Random) -> Fault:
        from hitab_core.operations import LoadLibrary, Perform

        if kind == "silent host":
            host = away.pop()
            os.kill(self.processes.pid(self.hosts[host][0]), signal.SIGSTOP)
            names = {*self.hosts[host]}
            squads = {s for s, members in self.squads.items() if names & {s, *members}}
            return Fault(kind, frozenset({host}), frozenset(names), frozenset(squads))
        squad = left.pop()
        members = dice.sample(self.squads[squad], dice.randint(1, MEMBERS_MAX))
        for name in members:
            if kind == "disobeys":
                self._do(name, Perform("Search"))
            else:
                folder = library(self.place / f"wrong_{name}", *WRONG_LIBRARIES[kind])
                self._do(name, LoadLibrary(str(folder)))
        return Fault(kind, frozenset(members), frozenset(members), frozenset({squad}))

    def _do(self, name: str, operation: Any) -> None:
        """Have an agent carry out an operation, on a busy machine at the third attempt."""
        from hitab_client import SwarmError

        for _ in range(2):
            with suppress(SwarmError):
                self.agents.do(name, operation)
                return
        self.agents.do(name, operation)

    def correct(self, item: Any) -> None:
        """Do what a person does about an item, with the remedies that it shows."""
        from hitab_client import SwarmError
        from hitab_client.attention import Kind
        from hitab_core import Fix
        from hitab_core.operations import Distribute, Perform

        given: dict[tuple[str, str], list[str]] = {}
        for remedy in item.remedies:
            arguments = dict(remedy.arguments)
            if remedy.code is Fix.GIVE:
                sent = arguments["agent"], arguments["behavior"]
                given.setdefault(sent, []).append(arguments["receiver"])
            elif remedy.code is Fix.PERFORM and item.kind is Kind.DISOBEYS:
                self._do(arguments["agent"], Perform(arguments["behavior"]))
        for (agent, behavior), receivers in given.items():
            try:
                report = self.agents.distribute(agent, Distribute(behavior, receivers=receivers))
            except SwarmError as error:
                typer.echo(f"  {behavior} was not sent: {error}")
            else:
                for name, why in report.missing.items():
                    typer.echo(f"  {name} did not take {behavior}: {why}")
        if item.kind is Kind.SILENT:
            for host in item.names:
                os.kill(self.processes.pid(self.hosts[host][0]), signal.SIGCONT)


def operate(swarm: Swarm, faults: list[Fault], ignored: str) -> Run:
    """Find and mend faults with the ranking, without items of an ignored kind."""
    run, began, done, corrected = Run(), time.monotonic(), set[tuple[Any, str]](), set[str]()
    while len(run.found) < len(faults) and time.monotonic() - began < LIMIT_S:
        items = [item for item in swarm.listen(0.1) if item.kind.value != ignored]
        present = {(item.kind, name) for item in items for name in item.names}
        done &= present  # what comes back deserves another look
        new = [item for item in items if not {(item.kind, name) for name in item.names} <= done]
        if not new:
            continue
        item = new[0]
        swarm.listen(LOOK_S)
        run.looks += 1
        done |= {(item.kind, name) for name in item.names}
        meant = [fault for fault in faults if fault.names & {*item.names}]
        if not meant:
            run.false.append(str(item))
            continue
        correcting = time.monotonic()
        swarm.listen(CORRECTION_S)
        swarm.correct(item)
        run.corrections += 1
        run.correcting_s += time.monotonic() - correcting
        corrected.update(item.names)
        for fault in meant:
            if fault.names <= corrected:
                run.found.setdefault(fault, (item.kind.value, time.monotonic() - began))
    run.seconds = time.monotonic() - began
    return run


def unguided(
    faults: list[Fault], correcting_s: float, places: list[str], where: Callable[[Fault], Any]
) -> tuple[float, float]:
    """Return time and looks of an operator without the ranking, medians of random orders."""
    seconds, looks = [], []
    for seed in range(ORDERS):
        order = {
            place: i + 1 for i, place in enumerate(random.Random(seed).sample(places, len(places)))
        }
        last = max(
            min(order[place] for place in where(fault) if place in order) for fault in faults
        )
        looks.append(last)
        seconds.append(last * LOOK_S + correcting_s)
    return median(seconds), median(looks)


def mended(swarm: Swarm, faults: list[Fault], seconds: float) -> list[Fault]:
    """Return the faults of which nothing is left in the statuses, after a while."""
    from hitab_msgs.msg import AgentStatus

    swarm.listen(seconds)
    statuses = swarm.agents.statuses
    usual = Counter(s.library_digest for n, s in statuses.items() if n.startswith("forager"))
    digest = usual.most_common(1)[0][0]
    silent = swarm.world.missing

    def is_right(name: str) -> bool:
        status: AgentStatus | None = statuses.get(name)
        if status is None or not name.startswith("forager"):
            return name not in silent
        ordered = status.order.behavior in ("", status.behavior)
        return name not in silent and ordered and status.library_digest == digest

    return [fault for fault in faults if all(map(is_right, fault.agents))]


def measure(agents: int, hosts: int, faults: int, seed: int, ignored: str) -> None:
    """Bring a swarm up, watch it while it is healthy, plant faults, have them mended."""
    from hitab_bringup.processes import supervision
    from hitab_bringup.processes.bringing_up import bring_up
    from hitab_bringup.swarm_files.swarm_file import parse_swarm
    from hitab_client import RosLink, RunFolder, domain_ids

    with (
        tempfile.TemporaryDirectory(prefix="hitab-attention-") as at,
        domain_ids.reserved() as id_,
    ):
        place = Path(at).resolve()
        os.environ["ROS_DOMAIN_ID"] = str(id_)
        swarm = parse_swarm(description(agents, hosts, seed), place / "attention.yaml")
        swarm = replace(swarm, name=f"attention_{os.getpid()}")
        run_folder = RunFolder(place / "run")
        bring_up(swarm, run_folder)
        try:
            with RosLink(id_) as link:
                up = Swarm(swarm, run_folder, link, place)
                up.listen(WARM_UP_S)
                alarms: dict[tuple[str, str, str], str] = {}
                end = time.monotonic() + HEALTHY_S
                while time.monotonic() < end:
                    alarms |= {item.key: str(item) for item in up.listen(0.5)}
                typer.echo(
                    f"seed {seed}: {len(alarms)} false alarms of the healthy swarm "
                    f"in {HEALTHY_S:.0f} s"
                )
                for text in alarms.values():
                    typer.echo(f"  {text}")
                planted = up.plant(faults, random.Random(seed))
                run = operate(up, planted, ignored)
                for fault in planted:
                    how, at_s = run.found.get(fault, ("not found", float("nan")))
                    typer.echo(
                        f"  {fault.kind}, {len(fault.agents)} agents: {how} at {at_s:.1f} s"
                    )
                for text in run.false:
                    typer.echo(f"  false alarm: {text}")
                right = mended(up, planted, 20.0)
                for fault in planted:
                    if fault not in right:
                        typer.echo(f"  not mended: {fault.kind} {sorted(fault.names)[:3]}")
                squads = unguided(
                    planted, run.correcting_s, [*up.squads], lambda fault: fault.squads
                )
                singly = unguided(
                    planted,
                    run.correcting_s,
                    [name for members in up.squads.values() for name in members],
                    lambda fault: fault.agents,
                )
                typer.echo(
                    f"  with the ranking:    {run.seconds:5.0f} s, {run.looks:3} looks, "
                    f"{run.corrections} corrections; {len(run.found)} of {len(planted)} found, "
                    f"{len(right)} mended"
                )
                for what, (seconds, looks) in (("squads", squads), ("agents", singly)):
                    typer.echo(
                        f"  without, by {what}:  {seconds:5.0f} s, {looks:3.0f} looks: "
                        f"{seconds / run.seconds:.1f} times as long"
                    )
        finally:
            for host in run_folder.processes():
                os.kill(host.pid, signal.SIGCONT)
            supervision.stop(run_folder)


def main(
    agents: Annotated[int, typer.Option(help="Number of agents, a multiple of 25.")] = 1000,
    hosts: Annotated[int, typer.Option(help="Number of host processes.")] = 8,
    faults: Annotated[int, typer.Option(help="Number of planted faults.")] = 10,
    seeds: Annotated[int, typer.Option(help="Number of seeds.")] = 3,
    first: Annotated[int, typer.Option(help="The first seed.")] = 1,
    ignore: Annotated[str, typer.Option(help="Kind of item to ignore, such as library.")] = "",
) -> None:
    """Measure a simulated operator, with the ranking of `hitab attention` and without."""
    for seed in range(first, first + seeds):
        measure(agents, hosts, faults, seed, ignore)


if __name__ == "__main__":
    typer.run(main)
