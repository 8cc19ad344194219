"""Verb that shows what deserves a look: attention."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_cli.verbs.verb_connection import connection
from hitab_client import console
from hitab_client.terminal.cli_options import JsonPath, SwarmName
from hitab_client.terminal.cli_remedies import as_command
from hitab_core import some
from hitab_ros.timing import POLL_S, UPDATE_S

if TYPE_CHECKING:
    from hitab_client.attention import Item

SHOWN_MAX = 20
"""Maximum number of items shown; JSON has all."""

WAYS_MAX = 3
"""Maximum number of remedies shown for an item; JSON has all."""


def attention(
    watch: Annotated[bool, typer.Option("--watch", "-w")] = False,
    seconds: Annotated[float, typer.Option("--seconds", "-s", min=0.0)] = 5.0,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """List what deserves a look, the most important first, and the command to go on with each.

    Listed are: machines, hosts and agents that do not answer; faults; members that do not perform
    their commander's order; agents that get nowhere although their mates in the same state do;
    robots that wait to be armed; decisions far from all examples; libraries that differ from those
    of the other agents. Alike cases of one group are one item. The more urgent kinds come first,
    and ten times as many agents count as much as the next more urgent kind.

    What agents usually do is learned by watching: stuck agents are found after a minute, so use
    --watch or --seconds 90. Far decisions are measured every ten seconds while somebody listens.

    Args:
        watch: Keep the list up to date.
        seconds: How long to listen before the list is shown, s.

    Examples:
      hitab attention
      hitab attention --watch
      hitab attention --seconds 90 --json -
    """
    from hitab_client.attention import AttentionListener

    with connection(swarm, reads=True) as swarm_up:
        swarm_up.agents.await_agents()
        listener = AttentionListener(swarm_up.agents, swarm_up.world, has_world=swarm_up.has_world)
        swarm_up.note_whose(status.swarm for status in swarm_up.agents.statuses.values())
        next_discovery = 0.0

        def looked() -> list[Item]:
            nonlocal next_discovery
            if time.monotonic() >= next_discovery:
                next_discovery = time.monotonic() + POLL_S + swarm_up.agents.more_seconds
                listener.discover()
            return listener.look()

        if watch:
            swarm_up.watch(lambda: _shown(looked()))
        end, items = time.monotonic() + seconds, looked()
        while time.monotonic() < end:
            swarm_up.link.spin_until(lambda: False, UPDATE_S)
            items = looked()
        now = time.monotonic()
        data = {"items": [item.data(as_command, now) for item in items]}
        console.show(json, data, *_shown(items))


def _shown(items: Sequence[Item]) -> list[Any]:
    """Return the lines that show items."""
    lines = []
    now = time.monotonic()
    for number, item in enumerate(items[:SHOWN_MAX], start=1):
        lines.append(console.line(f"{number}. {item} (for {now - item.since:.0f} s)", "bold"))
        if len(item.names) > 1:
            lines.append(console.line(f"   {some(item.names)}"))
        if item.why:
            lines.append(console.line(f"   {item.why}"))
        lines += [console.line(f"   {as_command(way)}") for way in item.remedies[:WAYS_MAX]]
        if len(item.remedies) > WAYS_MAX:
            lines.append(console.line(f"   and {len(item.remedies) - WAYS_MAX} more"))
    if len(items) > SHOWN_MAX:
        lines.append(console.line(f"and {len(items) - SHOWN_MAX} more", "dim"))
    return lines or [console.line("nothing deserves a look")]
