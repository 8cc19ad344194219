"""Verbs for command hierarchies: tree, order."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_bringup.verbs.connection import Connection, connection
from hitab_client import completion, console
from hitab_client.command_options import JsonPath, SwarmName
from hitab_core import Do, quantity

if TYPE_CHECKING:
    from rich.tree import Tree

    from hitab_client import Branch, CommandView

PANEL = "Command"
WAIT_SECONDS = 8.0
STARTED_BY_HAND_SECONDS = 1.5  # for commanders of a swarm that has started none
GROUP_SECONDS = 2.0  # once a commander's status is known, so is its group
REFRESH_SECONDS = 0.2
SHOWN = 12
"""Up to this many agents of a commander are shown individually."""


def register(app: typer.Typer) -> None:
    """Add these verbs to the command."""
    app.command(rich_help_panel=PANEL)(tree)
    app.command(rich_help_panel=PANEL)(order)


def tree(
    commander: Annotated[
        str, typer.Argument(help="Show only this commander and what is below it.")
    ] = "",
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Keep it up to date.")] = False,
    agents: Annotated[
        bool, typer.Option("--agents/--commanders", help="Show every agent, or commanders only.")
    ] = True,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show the command hierarchy: each commander's order, and how many agents perform it.

    Examples:

      hitab tree

      hitab tree squad_3

      hitab tree --watch --commanders
    """
    from hitab_client import CommandView

    with connection(swarm, reads=True) as swarm_up:
        view = CommandView(swarm_up.link, swarm_up.agents.prefix, swarm_up.agents.identity)
        lost = _await_commanders(swarm_up, view)
        swarm_up.note_whose(group.swarm for group in view.groups.values())
        tops = view.tree()
        if not tops:
            raise _nobody(swarm_up, view, lost)
        branches = _meant(tops, commander)
        if watch:
            _watch(swarm_up, view, commander, agents)
            return
        if json != "-":
            for branch in branches:
                console.out().print(_drawn(branch, agents))
        for why in lost:
            console.error(why)
        console.write_json(json, {"commanders": [branch.data() for branch in branches]})


def _await_commanders(swarm_up: Connection, view: CommandView) -> list[str]:
    """Wait for all commanders, and return why some will not answer."""
    if swarm_up.record is None:
        view.await_groups(WAIT_SECONDS)
        return []
    if not swarm_up.record.commanders:
        view.await_groups(STARTED_BY_HAND_SECONDS)
        return []
    from hitab_client.run_processes import sentences

    why = {name: swarm_up.processes.why_silent(name) for name in swarm_up.record.commanders}
    there = [name for name, silence in why.items() if silence is None or not silence.lasts]
    view.await_groups(WAIT_SECONDS + swarm_up.agents.more_seconds, there)
    view.discover()
    return sentences({n: silence for n, silence in why.items() if n not in view.groups})


def _nobody(swarm_up: Connection, view: CommandView, lost: Sequence[str]) -> Exception:
    from hitab_client import SwarmError
    from hitab_client.identity import other_swarm

    if lost:
        return SwarmError("\n".join(lost), Do.STATUS())
    for name, swarm in view.strangers.items():
        return other_swarm(name, swarm, swarm_up.agents.identity)
    if not swarm_up.agents.await_agents(seconds=0.5):
        return SwarmError("no commander answers, and no agent", Do.UP())
    return SwarmError(
        "no commander answers; a swarm has commanders if its description has `commanders:`"
    )


def _meant(tops: list[Branch], commander: str) -> list[Branch]:
    """Return the branch of a commander; all branches if none is named.

    Raises:
        SwarmError: if there is no such commander.
    """
    from hitab_client import SwarmError
    from hitab_core import has

    if not commander:
        return tops
    all_ = list(_commanders(tops))
    found = [branch for branch in all_ if branch.name == commander]
    if not found:
        raise SwarmError(
            f'no commander "{commander}" answers {has((b.name for b in all_), commander)}'
        )
    return found


def _commanders(branches: Iterable[Branch]) -> Iterator[Branch]:
    for branch in branches:
        if branch.is_commander:
            yield branch
            yield from _commanders(branch.below)


def _watch(swarm_up: Connection, view: CommandView, commander: str, agents: bool) -> None:
    from rich.console import Group

    def drawn() -> Group:
        return Group(*(_drawn(branch, agents) for branch in _meant(view.tree(), commander)))

    with console.live(drawn()) as update:
        while True:
            swarm_up.link.spin_until(lambda: False, REFRESH_SECONDS)
            view.discover()
            update(drawn())


def _drawn(branch: Branch, agents: bool, onto: Tree | None = None) -> Tree:
    """Return a branch as a tree of lines."""
    from rich.tree import Tree

    drawn = Tree(console.line(_line(branch), _style(branch)))
    if onto is not None:
        onto.children.append(drawn)
    for fault in branch.faults:
        drawn.add(console.line(fault, "red"))
    leaves = [member for member in branch.below if not member.is_commander]
    for member in branch.below:
        if member.is_commander:
            _drawn(member, agents, drawn)
    if agents:
        for text in _leaf_lines(leaves):
            drawn.add(text)
    return drawn


def _line(branch: Branch) -> str:
    doing = " > ".join((branch.behavior or "nothing", *branch.path))
    if not branch.is_commander:
        return f"{branch.name}: {doing}{_why_not(branch)}"
    mode = "" if branch.mode in ("performing", "idle", "") else f" ({branch.mode})"
    if not branch.order:
        return f"{branch.name}{mode}: {doing}, no order yet{_why_not(branch)}"
    does = "" if doing == branch.order else f"{doing}, "
    share = f"{branch.counts[0]} of {branch.counts[1]} perform it"
    if silent := sum(member.silent for member in branch.below):
        share += f" ({silent} silent)"
    of_agents = f"{branch.leaves[0]} of {branch.leaves[1]} agents"
    below = "" if branch.leaves == branch.counts else f", {of_agents}"
    return f"{branch.name}{mode}: {does}orders {branch.order}: {share}{below}{_why_not(branch)}"


def _why_not(branch: Branch) -> str:
    if branch.silent:
        return "  silent"
    return "  does not perform the order" if branch.obeys is False else ""


def _style(branch: Branch) -> str:
    if branch.silent or branch.faults:
        return "red"
    return "yellow" if branch.obeys is False else ""


def _leaf_lines(leaves: Sequence[Branch]) -> list[Any]:
    """Return one line per agent, or per behavior if there are many agents."""
    if len(leaves) <= SHOWN:
        return [console.line(_line(leaf), _style(leaf)) for leaf in leaves]
    alike: dict[tuple[str, str], list[Branch]] = {}
    for leaf in leaves:
        alike.setdefault((leaf.behavior or "nothing", _why_not(leaf)), []).append(leaf)
    return [
        console.line(
            f"{quantity(len(same), 'agent')}, {same[0].name} ...: {doing}{why}",
            _style(same[0]),
        )
        for (doing, why), same in alike.items()
    ]


def order(
    commander: Annotated[
        str,
        typer.Argument(
            help="Name of the commander, such as captain.", autocompletion=completion.commanders
        ),
    ],
    behavior: Annotated[
        str, typer.Argument(help="One of its orders, or a behavior that it has learned.")
    ],
    targets: Annotated[
        list[str] | None,
        typer.Argument(help="Targets for its parameters.", show_default=False),
    ] = None,
    swarm: SwarmName = None,
) -> None:
    """Make a commander give an order, or perform what it has learned; its group obeys at once.

    The next order from its own commander replaces this one.

    Examples:

      hitab order captain Regroup

      hitab order captain Captain
    """
    from hitab_client import CommandView
    from hitab_core import Use

    use = Use.parse(behavior)
    with connection(swarm) as swarm_up:
        view = CommandView(swarm_up.link, swarm_up.agents.prefix, swarm_up.agents.identity)
        status = swarm_up.agents.await_agent(commander)
        started = swarm_up.record.commanders if swarm_up.record is not None else ()
        if commander in swarm_up.agents.expected:
            _refuse_agent(commander, behavior, started)
        more = WAIT_SECONDS + swarm_up.agents.more_seconds
        view.await_groups(more if commander in started else GROUP_SECONDS, (commander,))
        _refuse_agent(commander, behavior, view.groups)
        swarm_up.agents.perform(commander, use.name, [*use.arguments, *(targets or [])])
        name = Use(use.name, (*use.arguments, *(targets or [])))
        swarm_up.link.spin_until(lambda: _obeyed(view.groups[commander], str(name)), 2.0)
        group = view.groups[commander]
    obeying = sum(member.obeys for member in group.subordinates)
    console.say(
        f"{commander} performs {name} and orders {group.order or 'nothing yet'}: "
        f"{obeying} of {len(group.subordinates)} perform it"
    )
    if status.superior:
        console.note(f"{status.superior} commands {commander}; its next order replaces this one")


def _refuse_agent(name: str, behavior: str, commanders: Collection[str]) -> None:
    from hitab_client import SwarmError
    from hitab_core import has

    if name not in commanders:
        raise SwarmError(
            f"{name} is not a commander {has(commanders, name)}",
            Do.PERFORM(agent=name, behavior=behavior),
        )


def _obeyed(group: Any, behavior: str) -> bool:
    """Whether a commander performs a behavior and the reachable members of its group obey."""
    if group.behavior != behavior or not group.order:
        return False
    return all(member.obeys or member.silent for member in group.subordinates)
