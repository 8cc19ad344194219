"""Disturbs a thousand agents on three machines, and compares the end with an undisturbed swarm.

Three network namespaces are the machines, joined by a switch that delays frames and loses some;
each has a HITAB_HOME of its own and starts its part with `hitab up FILE --machine NAME`. A person
on the first trains one agent of the third, and gives orders to the chief, all as any program can.
Meanwhile processes are killed, the third machine is lost, its agents are moved with `hitab move`,
and the second, which also drives two robots, is cut off while orders and a stop are given.

The undisturbed swarm is the same on a network that neither delays nor loses. What both are at the
end is compared by value. It must be run where network namespaces can be made (as root, or with
unprivileged user namespaces).

    scripts/python research/machines.py --agents 30 --kills 6 --rate 10 --seconds 10 --cuts 10
    scripts/python research/machines.py --preferred
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from machines_swarm import MACHINES, TESTS, Swarm, states, until

LOST, MOVED_TO = "lab_3", "lab_2"
CUT, DRIVERS = "lab_2", ("lab_2_host_1", "robot_1", "robot_2")
LONG = 120.0


class Table:
    """The phases of a run: what was done, how long until all obeyed, and how much came late."""

    def __init__(self, swarm: Swarm, agents: int) -> None:
        self._swarm, self._agents = swarm, agents
        typer.echo(f"{'':44}{'done after':>16}{'cycles':>8}{'late answers':>14}")

    def row(self, what: str, obeyed: float | None = None) -> None:
        """Print what was done since the last row."""
        cycles, late = self._swarm.ask("lateness")
        after = "" if obeyed is None else f"{obeyed:.1f} s"
        share = f"{late / cycles / self._agents:.1%}" if cycles else ""
        typer.echo(f"{what:44}{after:>16}{cycles:>8}{share:>14}")


def measure(swarm: Swarm, table: Table, seconds: float, what: str) -> None:
    """Play for a while."""
    swarm.ask("lateness")
    time.sleep(seconds)
    table.row(what)


def kill(swarm: Swarm, table: Table, kills: int, period: float, dice: random.Random) -> None:
    """Kill random processes, giving orders meanwhile; then order something."""
    killed: dict[str, int] = {}
    for number in range(kills):
        running = swarm.running()
        chosen = dice.choice(sorted(running))
        os.kill(running[chosen], signal.SIGKILL)
        kind = chosen[1].partition("_host")[1].strip("_") or chosen[1].partition("_")[0]
        kind = "machine" if kind == "lab" else kind
        killed[kind] = killed.get(kind, 0) + 1
        if number % 4 == 3:
            swarm.order(("Turn", "Work")[number // 4 % 2])
        time.sleep(period)
    order = "Halt"
    obeyed = swarm.obey(order)
    each = ", ".join(f"{count} {kind}" for kind, count in sorted(killed.items()))
    table.row(f"{kills} kills ({each})", obeyed)
    table.row("order", swarm.obey("Work"))


def lose(swarm: Swarm, table: Table) -> None:
    """Lose a machine, move its agents, and have it come back."""
    until(lambda: copied(swarm), "copies of what was learned")
    began = time.monotonic()
    swarm.network.cut_off(MACHINES[LOST])
    found = sorted(swarm.runs[LOST].processes(), key=lambda process: process.pid)
    for process in found:
        process.send_signal(signal.SIGKILL)
    for process in found:
        process.wait()
    swarm.ask("silent", LOST)
    table.row(f"{LOST} lost ({len(found)} processes): silent", time.monotonic() - began)
    began = time.monotonic()
    typer.echo("  " + swarm.hitab("lab_1", "move", LOST, "--to", MOVED_TO).replace("\n", "\n  "))
    swarm.obey("Turn")
    table.row(f"moved to {MOVED_TO}", time.monotonic() - began)
    swarm.network.heal()
    swarm.hitab(LOST, "up", str(swarm.file), "--machine", LOST)

    def yields() -> bool:
        return states(swarm.runs[LOST]).get(f"{LOST}_host_1", "EXITED") == "EXITED"

    began = time.monotonic()
    until(yields, f"{LOST} yields")
    swarm.ask("silent", LOST, False)
    table.row(f"{LOST} up again: yields, is heard", time.monotonic() - began)
    table.row("order", swarm.obey("Work"))
    began = time.monotonic()
    swarm.hitab("lab_1", "move", f"{LOST}_host_1", "--to", LOST)
    table.row(f"moved back to {LOST}", time.monotonic() - began)
    table.row("order", swarm.obey("Turn"))
    table.row("order", swarm.obey("Work"))


def copied(swarm: Swarm) -> bool:
    """Whether another machine has a copy of what the agents of one have learned."""
    theirs, copy = swarm.runs[LOST].path, swarm.runs[MOVED_TO].path / "copies" / LOST
    files = [*theirs.glob("libraries/*/*"), *theirs.glob("state/*/*.db*")]
    return all(
        (copy / path.relative_to(theirs)).exists()
        and (copy / path.relative_to(theirs)).read_bytes() == path.read_bytes()
        for path in files
        if path.is_file()
    )


def cut(swarm: Swarm, table: Table, seconds: float) -> None:
    """Cut a machine off while an order and a stop are given."""
    before = swarm.speeds()
    swarm.network.cut_off(MACHINES[CUT])
    began = time.monotonic()
    swarm.order("Turn")
    swarm.ask("obey", "Turn", DRIVERS)
    table.row(f"{CUT} cut off, order: the others obey", time.monotonic() - began)
    there = swarm.ask("places", DRIVERS[0])
    time.sleep(max(0.0, seconds / 2 - (time.monotonic() - began)))
    swarm.ask("stop", True, 2.0)
    time.sleep(max(0.0, seconds - (time.monotonic() - began)))
    during = swarm.speeds()
    moved = [
        name for name, place in swarm.ask("places", DRIVERS[0]).items() if place != there[name]
    ]
    swarm.network.heal()
    began = time.monotonic()
    swarm.ask("confirmed", LONG)
    until(lambda: all(s[-1] == "0" for s in swarm.speeds().values()), "the robots stop")
    table.row(f"{seconds:g} s later together again: the stop", time.monotonic() - began)
    stopped = swarm.speeds()
    if left := swarm.ask("stop", False, LONG):
        raise SystemExit(f"not released: {left}")
    swarm.ask("obey", "Turn", ["robot_1", "robot_2"])
    time.sleep(2.0)
    asked = {name: speeds[len(before[name]) :] for name, speeds in during.items()}
    typer.echo(f"  robots meanwhile: {asked}; foragers of {CUT} that moved: {len(moved)}")
    if swarm.speeds() != stopped:
        raise SystemExit(f"moved unasked: {swarm.speeds()} after {stopped}")
    swarm.ask("arm")
    swarm.ask("obey", "Turn", [])
    table.row("released and armed", time.monotonic() - began)
    table.row("order", swarm.obey("Work"))


def differences(found: dict[str, Any], wanted: dict[str, Any]) -> list[str]:
    """Return what differs, a line each."""
    lines = []
    for name in sorted(found.keys() | wanted.keys()):
        one, other = found.get(name), wanted.get(name)
        if one != other:
            lines.append(f"{name}: {one} instead of {other}")
    return lines


def main(
    agents: Annotated[int, typer.Option(help="Number of foragers.")] = 1000,
    rate: Annotated[float, typer.Option(help="Cycles per second.")] = 5.0,
    seconds: Annotated[float, typer.Option(help="Duration of the undisturbed minute.")] = 60.0,
    kills: Annotated[int, typer.Option(help="Number of kills.")] = 20,
    period: Annotated[float, typer.Option(help="Time between two kills, s.")] = 4.0,
    cuts: Annotated[str, typer.Option(help="Durations of the cuts, s.")] = "10,40",
    delay: Annotated[float, typer.Option(help="One way, s.")] = 0.02,
    loss: Annotated[float, typer.Option(help="Share of lost frames.")] = 0.05,
    seed: Annotated[int, typer.Option(help="Of the choice of processes to kill.")] = 1,
    preferred: Annotated[
        bool, typer.Option(help="Take precedence over other work on this machine; as root.")
    ] = False,
    domain: Annotated[int, typer.Option(help="ROS domain inside of the network.")] = 60,
) -> None:
    """Disturb a swarm on three machines, and compare it with an undisturbed one."""
    from lossy_network import LossyNetwork, why_not

    if why := why_not():
        raise SystemExit(why)
    if preferred:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))

    def run(name: str, delay: float, loss: float, play: Callable[[Swarm], None]) -> dict[str, Any]:
        with (
            tempfile.TemporaryDirectory(prefix="hitab-machines-") as place,
            LossyNetwork(len(MACHINES), delay, loss) as network,
        ):
            swarm = Swarm(Path(place).resolve(), network, agents, rate, domain)
            began = time.monotonic()
            with swarm.up():
                typer.echo(f"{name}: up after {time.monotonic() - began:.0f} s")
                swarm.ask("arm")
                swarm.ask("train", swarm.trained)
                play(swarm)
                state: dict[str, Any] = swarm.ask("state", swarm.trained)
                return state

    orders: list[str] = []

    def disturbed(swarm: Swarm) -> None:
        table = Table(swarm, agents)
        table.row("order", swarm.obey("Work"))
        measure(swarm, table, seconds, f"{seconds:g} s of peace")
        kill(swarm, table, kills, period, random.Random(seed))
        measure(swarm, table, seconds / 4, f"{seconds / 4:g} s of peace")
        lose(swarm, table)
        for duration in map(float, cuts.split(",")):
            cut(swarm, table, duration)
        measure(swarm, table, seconds / 4, f"{seconds / 4:g} s of peace")
        orders.extend(swarm.given)

    def undisturbed(swarm: Swarm) -> None:
        for order in orders:
            swarm.obey(order)

    typer.echo(f"{agents} agents, {rate:g} Hz, one way {delay * 1e3:.0f} ms, {loss:.0%} lost")
    found = run("disturbed", delay, loss, disturbed)
    wanted = run("undisturbed", 0.0, 0.0, undisturbed)
    lines = differences(found, wanted)
    typer.echo(f"{len(orders)} orders; {len(found)} values, {len(lines)} differ")
    for line in lines:
        typer.echo(f"  {line}")
    raise typer.Exit(bool(lines))


if __name__ == "__main__":
    sys.path.insert(0, str(TESTS))
    os.environ.setdefault("HITAB_HOME", tempfile.gettempdir())
    typer.run(main)
