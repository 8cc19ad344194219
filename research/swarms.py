"""Swarms of any size for benchmarks: agents in a tree of commanders, in a plain world."""

from __future__ import annotations

import math
from collections.abc import Iterator

FAN_OUT = 5
"""Subordinates of a commander."""

ORDERS = ("Explore", "Patrol", "Wait")


def levels(agents: int) -> Iterator[tuple[str, str, int]]:
    """Yield the levels of commanders from below: name, name of the level below, count."""
    below, count, level = "ant", agents, 1
    while count > 1:
        name = f"level{level}" if count > FAN_OUT else "root"
        count = math.ceil(count / FAN_OUT)
        yield name, below, count
        below, level = name, level + 1


def commanders(agents: int) -> int:
    """Return the number of commanders of a swarm with this many agents."""
    return sum(count for _, _, count in levels(agents))


def description(agents: int, hosts: int, world: str = "plain_world", factor: float = 1.0) -> str:
    """Return the description of a swarm whose agents' count is a power of five, or about one."""
    settings = f"factor: {factor}, parameters: {{agents: {agents}}}"
    lines = [
        "swarm: scale",
        f"domain: {world}:DOMAIN",
        "behavior: Explore",
        f"hosts: {hosts}",
        f"world: {{kind: plain, module: {world}, {settings}}}",
        "agents:",
        f"  ant: {{count: {agents}}}",
        "kinds:",
        f"  Leader: {{orders: {{{', '.join(f'{name}: {name}' for name in ORDERS)}}}}}",
        "commanders:",
    ]
    for name, below, count in levels(agents):
        whom = below if count == 1 else f"{{{below}: {FAN_OUT}}}"
        lines.append(f"  {name}: {{kind: Leader, commands: {whom}}}")
    return "\n".join(lines) + "\n"
