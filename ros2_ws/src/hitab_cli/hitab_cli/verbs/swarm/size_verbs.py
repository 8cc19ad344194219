"""Verb that predicts what a swarm takes on this machine: size."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_client import completion, console
from hitab_client.terminal.cli_options import JsonPath
from hitab_core import quantity

if TYPE_CHECKING:
    from hitab_bringup import Needs, SwarmDescription


def size(
    swarm: Annotated[str, typer.Argument(autocompletion=completion.swarm_descriptions)],
    library: Annotated[str | None, typer.Option("--library", "-l", metavar="LIBRARY")] = None,
    agents: Annotated[int, typer.Option(min=0)] = 0,
    seconds: Annotated[float, typer.Option(min=1.0)] = 10.0,
    check: Annotated[bool, typer.Option("--check")] = False,
    run_dir: Path | None = None,
    json: JsonPath = None,
) -> None:
    """Predict start-up, cores and memory of a swarm on this machine, from trial runs of parts.

    Each part has some of the agents, in whole squads under their commanders, in the whole world.
    It plays in a ROS domain of its own with copies of the libraries. A small swarm is run as a
    whole.

    Args:
        swarm: A swarm description, the name of a shipped one, or a Python file with a world.
        library: As for `hitab up`.
        agents: Number of agents, in a world in a Python file. 0: as in the file.
        seconds: How long to measure each part, s.
        check: Also run the whole swarm, and compare.
        run_dir: Run folder of the swarm, for its libraries, instead of the default one.

    Examples:
      hitab size thousand
      hitab size my_swarm.yaml --check --json size.json
    """
    import os

    import psutil  # type: ignore[import-untyped]

    from hitab_bringup import (
        described_swarm,
        lacks,
        predict,
        reduced,
        refuse_untriable,
        trial_sizes,
        try_out,
    )
    from hitab_client import RunFolder

    described = described_swarm(swarm, run_dir, library=library or "", agents=agents)
    refuse_untriable(described)
    folder, members = RunFolder.of_swarm(described.name, run_dir).path, len(described.members)
    cores, memory_mb = len(os.sched_getaffinity(0)), psutil.virtual_memory().available / 1e6

    def tried(part: SwarmDescription) -> Needs:
        with console.progress(f"trying {len(part.members)} of {members}", "nodes") as advance:
            return try_out(part, folder, seconds, advance)

    parts = [reduced(described, wanted / members) for wanted in trial_sizes(members)]
    trials = {len(part.members): tried(part) for part in parts}
    processes = len({member.process for member in described.members})
    predicted = predict(trials, members, min(cores, processes + 1))
    measured = tried(described) if check else None
    found = list(lacks(described, predicted, cores, memory_mb))
    data = {
        "swarm": described.name,
        "members": members,
        "cores": cores,
        "memory_mb": memory_mb,
        "trials": [{"members": count, **asdict(needs)} for count, needs in trials.items()],
        "predicted": asdict(predicted),
        "measured": None if measured is None else asdict(measured),
        "lacks": found,
    }
    is_lockstep = described.world is not None and described.world.pace == "lockstep"
    columns = {f"{count}": needs for count, needs in trials.items() if count != members}
    columns |= {f"{members}, predicted": predicted}
    columns |= {} if measured is None else {f"{members}, measured": measured}
    shown = [_shown(needs, is_lockstep=is_lockstep) for needs in columns.values()]
    rows = [[name, *(cells[name] for cells in shown)] for name in shown[0]]
    there = f"here: {quantity(cores, 'core')}, {memory_mb:,.0f} MB available"
    title = f"{described.name}: {quantity(len(described.agents), 'agent')}"
    title += f" and {quantity(len(described.commanders), 'commander')}; {there}"
    table = console.table(["agents and commanders", *columns], rows)
    console.show(json, data, title, table, *found)


def _shown(needs: Needs, *, is_lockstep: bool) -> dict[str, str]:
    """Return the lines of a table."""
    speed = {"cycles per second": f"{1000 / needs.cycle_ms:.0f}"}
    cores = {
        "cores, world": f"{needs.world_cores:.2f}",
        "cores, agents": f"{needs.agents_cores:.2f}",
    }
    return {
        "start, s": f"{needs.start_s:.1f}",
        "start, CPU s": f"{needs.start_cpu_s:.1f}",
        **(speed if is_lockstep else cores),
        "MB, world": f"{needs.world_mb:.0f}",
        "MB, agents": f"{needs.agents_mb:.0f}",
    }
