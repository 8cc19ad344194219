"""Verbs for emergencies: stop whatever acts, release it, and let robots act again."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_client import SwarmError, console, user_name
from hitab_client.commands import as_command, called, with_commands
from hitab_core import Do, some

if TYPE_CHECKING:
    from hitab_client import Stops

CONFIRM_S = 10.0
"""How long to repeat it until all have confirmed it, s."""

LOOK_S = 3.0
"""How long to look for robots that wait to be re-armed, s."""


def stop(context: typer.Context, reason: str = "") -> None:
    """Stop all robots and simulated worlds at once, of all swarms: an emergency stop.

    Each robot stands still, whatever its agent does, until `hitab go` and then `hitab arm`. Relays
    between agents and robots obey it even if an agent has died; goals of actions are cancelled;
    simulated worlds pause. The command repeats it until each of them has confirmed that it stands
    still, and fails, naming the others, if not all have within ten seconds. It takes no names:
    `hitab perform ROBOT` stops one robot.

    Args:
        reason: Why, for those who read the status.

    Examples:
      hitab stop
      hitab stop --reason "a dog on the field"
    """
    if context.args:
        raise typer.BadParameter(
            "it takes no names: it stops all robots; to stop one, "
            + as_command(Do.IDLE(agent=context.args[0]))
        )
    unsure = "assume that they move, use their own switches, and try again"
    console.say(f"stand still: {_switch(True, reason, 'stand still', unsure)}")


def go(context: typer.Context, reason: str = "") -> None:
    """Release all robots and simulated worlds after `hitab stop`.

    Worlds go on. Robots go on standing still: `hitab arm` lets them act again.

    Args:
        reason: Why, for those who read the status.

    Example:
      hitab go
    """
    if context.args:
        raise typer.BadParameter(
            "it takes no names: it releases all robots, and none moves by that; to "
            + as_command(Do.ARM(robot=context.args[0]))
        )
    unsure = "they may still be stopped; try again"
    heard = _switch(False, reason, "released", unsure)
    console.say(f"released: {heard}; robots wait for `{called()} arm`")


def arm(
    robots: Annotated[list[str] | None, typer.Argument()] = None,
    all_robots: Annotated[bool, typer.Option("--all")] = False,
) -> None:
    """Let robots act again that were stopped, whatever stopped them; without names, list them.

    A robot waits for this after each start of its relay, an emergency stop, a sensor or an agent
    that fell silent. It is refused while that lasts, and while the robot moves. What the agent
    performs then drives the robot at once: look at the robot first.

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
    with _everywhere() as ends:
        Stops.listen(ends, LOOK_S)
        waiting = {robot: why for end in ends for robot, why in end.waiting().items()}
        if not (robots or all_robots):
            for robot, why in waiting.items():
                console.say(with_commands(f"{robot}: {why}", [Do.GO(), Do.ARM(robot=robot)]))
            if not waiting:
                console.say("no robot waits")
            return
        for robot in robots or waiting:
            name = robot.strip("/")
            end = next((end for end in ends if name in end.names()), ends[0])
            try:
                end.arm(name, LOOK_S)
                console.say(f"{robot} may act")
            except SwarmError as error:
                refused.append(str(error))
    if refused:
        raise SwarmError("; ".join(refused))


def _switch(engaged: bool, reason: str, done: str, unsure: str) -> str:
    """Stop or release everything; return what has confirmed it.

    Args:
        engaged: whether to stop it.
        reason: that the user gives.
        done: what has been done to it then.
        unsure: what follows if not all confirm it.

    Raises:
        SwarmError: if nobody heard it, or not all confirm it.
    """
    from hitab_client import Stops

    def tell(who: dict[str, str]) -> None:
        console.note(f"waiting for {_listed(who)}")

    with _everywhere() as ends:
        by = user_name()
        lacking = Stops.switch_all(ends, by, reason, engaged=engaged, seconds=CONFIRM_S, tell=tell)
        there = [name for end in ends for name in end.names()]
        where = " or ".join(str(end.domain_id) for end in ends)
    if not there:
        raise SwarmError(
            f"nobody heard it: no robot and no simulated world answers in ROS domain {where}; "
            "use the robots' own switches, check ROS_DOMAIN_ID and "
            "ROS_AUTOMATIC_DISCOVERY_RANGE, and try again",
            Do.DOCTOR(),
        )
    confirmed = [name for name in there if name not in lacking]
    if lacking:
        others = f"; {done}: {some(confirmed)}" if confirmed else ""
        raise SwarmError(f"not confirmed: {_listed(lacking)}; {unsure}{others}")
    return some(confirmed)


def _listed(who: dict[str, str]) -> str:
    return ", ".join(f"{name} ({why})" for name, why in who.items())


@contextmanager
def _everywhere() -> Iterator[list[Stops]]:
    """Yield what is in the user's ROS domain, and in those of all swarms that are up."""
    from hitab_client import RosLink, Stops
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.run_folder import running_swarms

    expected: dict[int, set[str]] = {chosen_by_user() or 0: set()}
    for _, record in running_swarms():
        # Without a simulated world, agents that command no others drive robots.
        robots = () if record.world else set(record.agents) - set(record.commanders)
        prefix = f"{record.namespace.strip('/')}/".lstrip("/")
        expected.setdefault(record.domain_id, set()).update(f"{prefix}{name}" for name in robots)
    with ExitStack() as stack:
        yield [
            Stops(stack.enter_context(RosLink(number)), robots)
            for number, robots in sorted(expected.items())
        ]
