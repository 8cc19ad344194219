"""Compares squads of scouts and carriers with squads without roles, on the same fields.

Scouts see far and cannot grip; carriers see little. What the shipped lessons have taught plays in
one process: by role, with roles given to the wrong robots at random, and with the same commands
meaning the same for all robots. Beside them plays what has no example.

    scripts/python research/foraging_roles.py --resume roles.jsonl --json roles.json
"""

from __future__ import annotations

import json as js
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from random import Random
from typing import Annotated

import typer
from finished_runs import FinishedRuns, Resume
from foraging import chosen, compared, in_fives, interval, trained
from foraging_tasks import forager_rules
from tasks import library, rule

from foraging_world.domain import DOMAIN
from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_client.runs.shipped import shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.inprocess import Commander, HierarchyPlayers, Member
from hitab_commander.kinds.kind import CommanderKind, OrderMap
from hitab_core import Automaton
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.orders import ALL_OTHERS
from hitab_world.inprocess import play

_SMALL = ForagingParameters(
    foragers=10,
    scouts=1,
    scout_sight=12.0,
    sight=2.0,
    small_boxes=3,
    small_pullers=3,
    large_boxes=0,
    duration=200.0,
)
FIELDS = {
    "small": _SMALL,
    "large": replace(_SMALL, width=80.0, height=80.0, pull_speed=1.0),
}
FIRST_SEED = {"small": 7001, "large": 8001}
ROLES = "roles"
KIND = "foraging_roles"
TOP = "Collect"
ALIKE = {"Explore": "Search", "Fetch": "Help", "Haul": "Help"}
"""What each order means for all robots, where there are no roles."""
CYCLES = 100
"""After which another random order is given."""


def shipped_roles(names: Iterable[str]) -> dict[str, str]:
    """Return the roles that suit robots."""
    return {name: name.partition("_")[0] for name in names}


def shuffled(names: Sequence[str], seed: int) -> dict[str, str]:
    """Return the same roles, dealt out at random in each squad."""
    random, roles = Random(seed), shipped_roles(names)
    dealt: dict[str, str] = {}
    for squad in in_fives(names):
        given = [roles[name] for name in squad]
        random.shuffle(given)
        dealt.update(zip(squad, given, strict=True))
    return dealt


def without_roles(kind: CommanderKind) -> CommanderKind:
    """Return a kind of commander whose orders and features are the same for all."""
    orders = tuple(OrderMap(order.name, {ALL_OTHERS: ALIKE[order.name]}) for order in kind.orders)
    features = tuple(replace(feature, role="") for feature in kind.features)
    return replace(kind, orders=orders, features=features)


def robot_rules() -> dict[str, Automaton]:
    """Return the robots' automata with a rule of one line for each state."""
    approach = rule(
        "Approach(A)",
        "GoTo(A) Stop",
        "DistanceTo(A)",
        rest=lambda distance: "GoTo(A)" if distance > 2.5 else "Stop",
    )
    help_ = rule(
        "Help",
        "Carry(scouted_box) Carry(squad_box)",
        "Sees(squad_box)",
        rest=lambda holds: "Carry(squad_box)" if holds else "Carry(scouted_box)",
    )
    return {**forager_rules(), "Approach": approach, "Help": help_}


def commanded(kind: CommanderKind, choose: Callable[..., str]) -> BehaviorLibrary:
    """Return the library of a commander with a rule of one line."""
    orders = " ".join(order.name for order in kind.orders)
    collect = rule(TOP, orders, "ScoutSees SomeoneHolds", rest=choose)
    return library(replace(commander_domain(kind), automata={TOP: collect}))


def complete(sees: float, holds: float) -> str:
    """Return the order for a situation."""
    return "Fetch" if sees else "Haul" if holds else "Explore"


def at_random(seed: int) -> Callable[..., str]:
    """Return what gives another order at random, now and then."""
    random, given, left = Random(seed), "", 0

    def choose(*_: float) -> str:
        nonlocal given, left
        if not left:
            given, left = random.choice(list(ALIKE)), CYCLES
        left -= 1
        return given

    return choose


def hierarchy(row: str, names: Sequence[str], seed: int) -> HierarchyPlayers:
    """Return the robots and commanders of a row of the table."""
    kind, of_commanders = trained(KIND)
    robots = BehaviorLibrary(shipped("libraries", "foraging"), DOMAIN)
    roles = shipped_roles(names)
    if row == "each for itself":
        return HierarchyPlayers([Member(name, robots, "Forage") for name in names])
    if row.endswith(" alone"):
        (order,) = (o for o in kind.orders if row == f"{o.name} alone")
        return HierarchyPlayers(
            [Member(name, robots, order.for_role(roles[name]) or "") for name in names]
        )
    made: list[Commander] = []
    if row == "rules for roles":
        robots = library(replace(DOMAIN, automata=robot_rules()))
        of_commanders = commanded(kind, complete)
    elif row == "roles shuffled":
        roles = shuffled(names, seed)
    elif row == "no roles":
        kind = without_roles(kind)
        of_commanders = library(
            replace(commander_domain(kind), automata=dict(of_commanders.load()))
        )
    for number, squad in enumerate(in_fives(names), 1):
        if row == "random orders":
            of_commanders = commanded(kind, at_random(100 * seed + number))
        made.append(Commander(f"squad_{number}", kind, of_commanders, TOP, squad, roles))
    return HierarchyPlayers([Member(name, robots) for name in names], made)


ROWS = (
    *(ROLES, "roles shuffled", "no roles", "each for itself", "rules for roles"),
    *("random orders", *(f"{order} alone" for order in ALIKE)),
)


def boxes(run: tuple[str, str, int]) -> float:
    """Play one run; return how many boxes came home."""
    field, row, seed = run
    world = ForagingWorld(FIELDS[field], seed)
    made = hierarchy(row, world.agents, seed)
    (result,) = play(world, made.players, between=made.confer)
    return result.measures["boxes"]


def main(
    field: Annotated[str, typer.Option(help=f"One of: {', '.join(FIELDS)}.")] = "large",
    runs: Annotated[int, typer.Option(min=2, help="Runs of each row.")] = 30,
    first_seed: Annotated[int, typer.Option(help="Of the first run; counts up.")] = 0,
    only: Annotated[list[str] | None, typer.Option(help="Only these rows.")] = None,
    processes: Annotated[int, typer.Option(help="Parallel runs.")] = os.cpu_count() or 1,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    resume: Resume = "",
) -> None:
    """Compare squads of scouts and carriers."""
    finished = FinishedRuns(resume, FIELDS[chosen([field], FIELDS, "field")[0]].as_dict())
    first = first_seed or FIRST_SEED[field]
    rows = chosen(only, dict.fromkeys(ROWS), "row")
    plan = [(field, row, first + i) for i in range(runs) for row in rows]
    missing = [run for run in plan if "{1}, seed {2}".format(*run) not in finished.figures]
    with ProcessPoolExecutor(processes) as pool:
        for count, (run, brought) in enumerate(
            zip(missing, pool.map(boxes, missing), strict=True), 1
        ):
            finished.add("{1}, seed {2}".format(*run), brought)
            print(f"\r{count} of {len(missing)} runs", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    figures: dict[str, list[float]] = {}
    for _, row, seed in plan:
        figures.setdefault(row, []).append(finished.figures[f"{row}, seed {seed}"])
    report(figures)
    if json:
        with open(json, "w", encoding="utf-8") as file:
            js.dump(figures, file, indent=1)


def report(figures: Mapping[str, Sequence[float]]) -> None:
    """Print boxes by row, and how many fewer than with roles."""
    for row, brought in figures.items():
        told = "{mean:6.2f} ± {ci95:.2f} boxes".format(**interval(brought))
        if row != ROLES and ROLES in figures:
            told += ", {mean:6.2f} ± {ci95:.2f} fewer than with roles".format(
                **compared(figures[ROLES], brought)
            )
        print(f"{row:18}{told}")


if __name__ == "__main__":
    typer.run(main)
