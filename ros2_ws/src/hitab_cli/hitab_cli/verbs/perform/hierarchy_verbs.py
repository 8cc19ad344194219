"""Verbs for command hierarchies: tree, order."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import SwarmError, completion, console
from hitab_client.terminal.cli_options import JsonPath, SwarmName
from hitab_client.terminal.cli_remedies import with_commands
from hitab_core import Fix, Term, has, quantity
from hitab_core.operations import Perform
from hitab_ros.timing import DISCOVERY_S, PROMPT_S, SETTLE_S

if TYPE_CHECKING:
    from rich.tree import Tree

    from hitab_client import Branch, CommanderView

SUBORDINATES_SHOWN_MAX = 12
"""Maximum number of a commander's agents that are shown individually."""


def tree(
    commander: Annotated[str, typer.Argument()] = "",
    watch: Annotated[bool, typer.Option("--watch", "-w")] = False,
    agents: Annotated[bool, typer.Option("--agents/--commanders")] = True,
    swarm: SwarmName = None,
    json: JsonPath = None,
) -> None:
    """Show the command hierarchy: each commander's order, and how many agents perform it.

    Args:
        commander: Show only this commander and its subordinates.
        watch: Keep it up to date.
        agents: Show every agent, or commanders only.

    Examples:
      hitab tree
      hitab tree squad_3
      hitab tree --watch --commanders
    """
    from hitab_client import CommanderView

    with connection(swarm, reads=True) as swarm_up:
        view = CommanderView(swarm_up.agents)
        if swarm_up.machines is not None:
            swarm_up.machines.listen()
        lost = _await_commanders(swarm_up, view)
        swarm_up.note_whose(group.swarm for group in view.groups.values())

        machines = swarm_up.machines
        of = machines.elsewhere if machines is not None else lambda name: ""

        def drawn() -> list[Any]:
            view.discover()
            silent = (
                [f"{it} {machines.why_silent(it)}" for it in machines.silent()] if machines else ()
            )
            branches = _branches(view, commander, lost)
            return [
                *(console.line(text, "red") for text in silent),
                *(_drawn(branch, agents, of) for branch in branches),
            ]

        if watch:
            swarm_up.watch(drawn)
        branches = _branches(view, commander, lost)
        data: dict[str, Any] = {"commanders": [branch.data() for branch in branches]}
        if machines is not None:
            data["machines"] = machines.data()
        console.show(json, data, *drawn())
        for branch in branches if json is None else ():
            if branch.order and branch.order == branch.behavior:
                text = f"{branch.name} gives {branch.order} until another order"
                console.note(with_commands(text, [Fix.PERFORM(agent=branch.name)]))
        for why in lost:
            console.error(why)


def _await_commanders(swarm_up: Connection, view: CommanderView) -> list[str]:
    """Wait for all commanders, and return the reasons of those that will not answer."""
    started = swarm_up.record.commanders if swarm_up.record is not None else ()
    if not started:
        by_hand = swarm_up.record is None
        view.await_groups(DISCOVERY_S if by_hand else SETTLE_S)
        return []
    from hitab_client.runs.run_processes import sentences

    why = {name: swarm_up.processes.why_silent(name) for name in started}
    lost = swarm_up.agents.lost_of(started)
    awaited = [name for name in started if name not in lost]
    view.await_groups(DISCOVERY_S + swarm_up.agents.more_seconds, awaited)
    view.discover()
    return sentences({n: silence for n, silence in why.items() if n not in view.groups})


def _branches(view: CommanderView, commander: str, lost: Sequence[str]) -> list[Branch]:
    """Return the branch of a commander; all branches if none is named.

    Raises:
        SwarmError: if there are no commanders, or not this one; names those that do not answer.
    """
    from hitab_client import tree_of

    tops = tree_of(view.groups)
    all_ = {branch.name: branch for top in tops for branch in top.commanders()}
    if commander in all_ or (tops and not commander):
        return [all_[commander]] if commander else tops
    if tops:
        raise SwarmError(f'no commander "{commander}" answers {has(all_, commander)}')
    if lost:
        raise SwarmError("\n".join(lost), Fix.STATUS())
    view.refuse_strangers(view.strangers)
    raise SwarmError(
        "no commander answers; a swarm has commanders if its description has `commanders:`",
        Fix.STATUS(),
    )


def _drawn(branch: Branch, agents: bool, of: Callable[[str], str]) -> Tree:
    """Return a branch as a tree of lines; ``of`` returns a text on the machine of an agent."""
    from rich.tree import Tree

    drawn = Tree(console.line(line_of(branch) + of(branch.name), _style(branch)))
    for fault in branch.faults:
        drawn.add(console.line(fault, "red"))
    drawn.children += [_drawn(m, agents, of) for m in branch.below if m.is_commander]
    for text in _leaf_lines([m for m in branch.below if not m.is_commander], of) if agents else ():
        drawn.add(text)
    return drawn


def line_of(branch: Branch) -> str:
    """Return the activity of a commander or an agent, in one line."""
    doing = " > ".join((branch.behavior or "nothing", *branch.path))
    if not branch.is_commander:
        return f"{branch.name}: {doing}{_why_not(branch)}"
    mode = "" if branch.mode in ("performing", "idle", "") else f" ({branch.mode})"
    if not branch.order:
        return f"{branch.name}{mode}: {doing}, no order yet{_why_not(branch)}"
    does = "" if doing == branch.order else f"{doing}, "
    share = f"{branch.counts[0]} of {branch.counts[1]} perform it{_unable(branch.below)}"
    of_agents = f"{branch.leaves[0]} of {branch.leaves[1]} agents"
    below = "" if branch.leaves == branch.counts else f", {of_agents}"
    return f"{branch.name}{mode}: {does}orders {branch.order}: {share}{below}{_why_not(branch)}"


def _unable(members: Sequence[Any]) -> str:
    """Return a text on the members that cannot perform an order; empty if all can."""
    silent = sum(member.silent for member in members)
    stopped = sum(member.stopped and not member.silent for member in members)
    reasons = ", ".join(
        [f"{silent} silent"] * (silent > 0) + [f"{stopped} stopped"] * (stopped > 0)
    )
    return f" ({reasons})" if reasons else ""


def _why_not(branch: Branch) -> str:
    if branch.silent:
        return "  silent"
    if branch.stopped:
        return "  stopped"
    return "  does not perform the order; obeys the next one" if branch.obeys is False else ""


def _style(branch: Branch) -> str:
    if branch.silent or branch.stopped or branch.faults:
        return "red"
    return "yellow" if branch.obeys is False else ""


def _leaf_lines(leaves: Sequence[Branch], of: Callable[[str], str]) -> list[Any]:
    """Return one line per agent, or per behavior if there are many agents."""
    if len(leaves) <= SUBORDINATES_SHOWN_MAX:
        return [console.line(line_of(leaf) + of(leaf.name), _style(leaf)) for leaf in leaves]
    alike: dict[tuple[str, str], list[Branch]] = {}
    for leaf in leaves:
        why = f"{_why_not(leaf)}{of(leaf.name)}"
        alike.setdefault((leaf.behavior or "nothing", why), []).append(leaf)
    return [
        console.line(
            f"{quantity(len(same), 'agent')}, {same[0].name} ...: {doing}{why}", _style(same[0])
        )
        for (doing, why), same in alike.items()
    ]


def order(
    commander: Annotated[str, typer.Argument(autocompletion=completion.commanders)],
    behavior: str,
    targets: Annotated[list[str] | None, typer.Argument()] = None,
    swarm: SwarmName = None,
) -> None:
    """Make a commander give an order, or perform a learned behavior; its group obeys at once.

    The next order from its own commander replaces this one.

    Args:
        commander: Name of the commander, such as captain.
        behavior: One of its orders, or a learned behavior.
        targets: Targets for its parameters.

    Examples:
      hitab order captain Regroup
      hitab order captain Captain
    """
    from hitab_client import CommanderView

    term = Term.parse(behavior)
    term = Term(term.name, (*term.arguments, *(targets or [])))
    with connection(swarm) as swarm_up:
        view = CommanderView(swarm_up.agents)
        status = swarm_up.agents.await_agent(commander)
        started = swarm_up.record.commanders if swarm_up.record is not None else ()
        if commander in swarm_up.agents.expected:
            _refuse_agent(commander, behavior, started)
        more = DISCOVERY_S + swarm_up.agents.more_seconds
        view.await_groups(more if commander in started else PROMPT_S, (commander,))
        _refuse_agent(commander, behavior, view.groups)
        swarm_up.agents.do(commander, Perform(term.name, term.arguments))
        swarm_up.link.spin_until(lambda: _obeyed(view.groups[commander], str(term)), 2.0)
        group = view.groups[commander]
    obeying = sum(member.obeys for member in group.subordinates)
    console.say(
        f"{commander} performs {term} and orders {group.order or 'nothing yet'}: "
        f"{obeying} of {len(group.subordinates)} perform it{_unable(group.subordinates)}"
    )
    if status.mode == "performing" and status.behavior != str(term):
        again = Fix.PERFORM(agent=commander, behavior=status.behavior)
        console.note(with_commands(f"before, it performed {status.behavior}", [again]))
    if superior := status.order.commander:
        console.note(f"{superior} commands {commander}; its next order replaces this one")


def _refuse_agent(name: str, behavior: str, commanders: Collection[str]) -> None:

    if name not in commanders:
        raise SwarmError(
            f"{name} is not a commander {has(commanders, name)}",
            Fix.PERFORM(agent=name, behavior=behavior),
        )


def _obeyed(group: Any, behavior: str) -> bool:
    """Whether a commander performs a behavior and the reachable members of its group obey."""
    if group.behavior != behavior or not group.order:
        return False
    return all(member.obeys or member.silent or member.stopped for member in group.subordinates)
