"""Verbs for emergencies: stop, go, arm."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_client import SwarmError, console, user_name
from hitab_client.terminal.cli_options import SwarmName
from hitab_client.terminal.cli_remedies import as_command, called, with_commands
from hitab_core import Fix, has, some
from hitab_ros.timing import ANSWER_S, FOUND_S

if TYPE_CHECKING:
    from hitab_client import Stops


def stop(
    context: typer.Context,
    reason: str = "",
    wait: Annotated[float, typer.Option(metavar="SECONDS", show_default=False)] = math.inf,
) -> None:
    """Stop all robots and simulated worlds at once, of all swarms: an emergency stop.

    Each robot stands still, whatever its agent does, until `hitab go` and then `hitab arm`. Relays
    between agents and robots obey it even if an agent has died; goals of actions are cancelled;
    simulated worlds pause. The command repeats the stop until each robot has confirmed standing
    still, so a robot out of reach obeys when it is back; after ten seconds the command names the
    others. It takes no names: `hitab perform ROBOT` stops one robot.

    Args:
        reason: Reason, shown in statuses.
        wait: Fail if not all have confirmed within this time, s. Default: no limit.

    Examples:
      hitab stop
      hitab stop --reason "a dog on the field"
    """
    if context.args:
        raise typer.BadParameter(
            "it takes no names: it stops all robots; to stop one, "
            + as_command(Fix.IDLE(agent=context.args[0]))
        )
    unsure = "assume that they move, use their own switches, and try again"
    console.say(f"stand still: {_switch(True, reason, 'stand still', unsure, wait)}")


def go(context: typer.Context, reason: str = "") -> None:
    """Release all robots and simulated worlds after `hitab stop`, of all swarms.

    Worlds resume. Robots keep standing still until `hitab arm`. A stop that arrives meanwhile
    remains in force.

    Args:
        reason: Reason, shown in statuses.

    Example:
      hitab go
    """
    if context.args:
        raise typer.BadParameter(
            "it takes no names: it releases all robots, and none moves by that; to "
            + as_command(Fix.ARM(robot=context.args[0]))
        )
    unsure = "they may still be stopped; try again"
    confirmed = _switch(False, reason, "released", unsure, ANSWER_S)
    console.say(f"released: {confirmed}; robots wait for `{called()} arm`")


def arm(
    robots: Annotated[list[str] | None, typer.Argument()] = None,
    all_robots: Annotated[bool, typer.Option("--all")] = False,
    swarm: SwarmName = None,
) -> None:
    """Re-arm stopped robots, which then act again; without names, list them.

    A robot waits for this after each start of its relay, an emergency stop, or the silence of a
    sensor or of its agent. Re-arming is refused while the cause lasts, and while the robot moves.
    The agent's behavior drives the robot at once: look at the robot first. The names are those of
    the swarm that is up; if none is up, of the robots in ROS_DOMAIN_ID.

    Args:
        robots: Names of robots.
        all_robots: All robots that wait.

    Examples:
      hitab arm
      hitab arm robot_1 robot_2
      hitab arm --all
    """
    from hitab_client import Stops

    if robots and all_robots:
        raise typer.BadParameter("give names of robots or --all, not both")
    refused = []
    with _chosen_robots(swarm) as (end, prefix, own):
        where = f"in ROS domain {end.domain_id}"
        Stops.listen([end], FOUND_S)
        waiting = {
            name: it
            for name, it in end.waiting().items()
            if name.startswith(prefix) and (not own or name in own)
        }
        for name, (why, is_held) in ({} if robots or all_robots else waiting).items():
            ways = [Fix.GO(), Fix.ARM(robot=name)] if is_held else [Fix.ARM(robot=name)]
            console.say(with_commands(f"{name}: {why}", ways))
        if not (robots or waiting):
            console.say(f"no robot waits {where}")
        for robot in robots or (waiting if all_robots else ()):
            name = robot.strip("/")
            name = name if name.startswith(prefix) else f"{prefix}{name}"
            try:
                if own and name not in own:
                    raise SwarmError(f"{robot} is not in this swarm {has(own, name)}")
                end.arm(name, FOUND_S)
                console.say(f"{robot} may act {where}")
            except SwarmError as error:
                refused.append(str(error))
    if refused:
        raise SwarmError("; ".join(refused))


def _switch(engaged: bool, reason: str, done: str, unsure: str, seconds: float) -> str:
    """Stop or release all robots and worlds; return the names of those that have confirmed.

    Args:
        engaged: whether to stop, not to release.
        reason: given by the user.
        done: participle for messages, such as "stopped".
        unsure: the consequence if not all confirm.
        seconds: longest time to repeat the request until all have confirmed.

    Raises:
        SwarmError: if no robot or world is found, or not all confirm.
    """
    from hitab_client import Stops

    shown: list[object] = []

    def tell(who: dict[str, str], after: float) -> None:
        is_late = after > ANSWER_S and seconds > ANSWER_S
        if [who, is_late] == shown or not (who or is_late):
            return
        shown[:] = who, is_late
        if is_late:
            whom = _listed(who) or f"no node answers in ROS domain {where}"
            console.note(
                f"not confirmed: {whom}; {unsure}; the command goes on, so that they obey when "
                "they are back, until all confirm it or Ctrl-C"
            )
        else:
            console.note(f"waiting for {_listed(who)}")

    with _everywhere() as ends:
        where = " or ".join(str(end.domain_id) for end in ends)
        by = user_name()
        lacking = Stops.switch_all(ends, by, reason, engaged=engaged, seconds=seconds, tell=tell)
        found = [end.label(name, ends) for end in ends for name in end.names()]
    if not found:
        raise SwarmError(
            "the stop was not heard: no robot and no simulated world answers in ROS domain "
            f"{where}; use the robots' own switches, check ROS_DOMAIN_ID and "
            "ROS_AUTOMATIC_DISCOVERY_RANGE, and try again",
            Fix.DOCTOR(),
        )
    confirmed = [name for name in found if name not in lacking]
    if lacking:
        others = f"; {done}: {some(confirmed)}" if confirmed else ""
        raise SwarmError(f"not confirmed: {_listed(lacking)}; {unsure}{others}")
    return some(confirmed)


def _listed(who: dict[str, str]) -> str:
    return ", ".join(f"{name} ({why})" for name, why in who.items())


@contextmanager
def _everywhere() -> Iterator[list[Stops]]:
    """Yield the swarms in the user's ROS domain and in the domains of all swarms that are up."""
    from hitab_client import RosLink, Stops
    from hitab_client.connecting.domain_ids import chosen_by_user
    from hitab_client.runs.run_folder import running_swarms

    expected: dict[int, set[str]] = {chosen_by_user() or 0: set()}
    for _, record in running_swarms():
        # Without a simulated world, agents that command no others drive robots.
        robots = () if record.world else set(record.agents) - set(record.commanders)
        names = {f"{_prefix(record.namespace)}{name}" for name in robots}
        expected.setdefault(record.domain_id, set()).update(names)
    with ExitStack() as stack:
        yield [
            Stops(stack.enter_context(RosLink(number)), robots)
            for number, robots in sorted(expected.items())
        ]


@contextmanager
def _chosen_robots(swarm: str | None) -> Iterator[tuple[Stops, str, set[str]]]:
    """Yield a swarm's ROS domain, the prefix of its robots' names, and the names; empty for any.

    Args:
        swarm: the swarm; None for the only one that is up, or nodes started by hand.

    Raises:
        SwarmError: if several are up and none is named, or the named swarm is not up.
    """
    from hitab_client import RosLink, Stops
    from hitab_client.connecting.domain_ids import chosen_by_user
    from hitab_client.runs.swarm_choice import find_meant, is_namespace, look_elsewhere

    chosen = chosen_by_user()
    found = find_meant(swarm, chosen)
    record = found[1] if found else None
    with RosLink(record.domain_id if record else chosen or 0) as link:
        if record:
            prefix = _prefix(record.namespace)
        elif swarm and not is_namespace(swarm):
            prefix = _prefix(look_elsewhere(link, identity=swarm))
        else:
            prefix = _prefix(swarm or "")
        own = {f"{prefix}{name}" for name in record.agents} if record else set()
        yield Stops(link, own), prefix, own


def _prefix(namespace: str) -> str:
    return f"{namespace.strip('/')}/".lstrip("/")
