"""Verbs for emergencies: stop all robots, and release them."""

from __future__ import annotations

import getpass
import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_client import console

if TYPE_CHECKING:
    from hitab_client import RosLink
    from hitab_ros import EmergencySwitch

LOOK_S = 3.0
"""How long to look for robots, s."""

LINGER_S = 0.7
"""How long to look for more after the last one was found, s."""

DELIVER_S = 2.0
"""How long to wait until all robots that were found have the message, s."""

Reason = Annotated[str, typer.Option("--reason", help="Why, for those who read the status.")]


def register(app: typer.Typer) -> None:
    """Add these verbs to the command."""
    # Names that somebody gives in the belief that they choose robots are refused with a reason.
    names = {"allow_extra_args": True}
    app.command(rich_help_panel="Perform", context_settings=names)(stop)
    app.command(rich_help_panel="Perform", context_settings=names)(go)


def stop(context: typer.Context, reason: Reason = "") -> None:
    """Stop all robots at once, of all swarms: an emergency stop.

    Each robot stands still, whatever its agent does, until `hitab go`. The relays between agents
    and robots obey it even if an agent has died; simulated worlds go on. It takes no names:
    `hitab perform ROBOT` stops one robot.

    Examples:

      hitab stop

      hitab stop --reason "a dog on the field"
    """
    if context.args:
        raise typer.BadParameter(
            "`hitab stop` takes no names: it stops all robots; "
            f"`hitab perform {context.args[0]}` stops one of them"
        )
    _tell(
        "stopped",
        True,
        reason,
        "use the robot's own switch",
        "assume that some still move, and use their own switches",
    )


def go(context: typer.Context, reason: Reason = "") -> None:
    """Release all robots after `hitab stop`.

    Agents that went on performing drive on at once.

    Example:

      hitab go
    """
    if context.args:
        raise typer.BadParameter("`hitab go` takes no names: it releases all robots")
    _tell("released", False, reason, "none was released", "some may still stand")


def _tell(done: str, engaged: bool, reason: str, unheard: str, unsure: str) -> None:
    """Stop or release all robots.

    Args:
        done: what has been done to them then.
        engaged: whether they have to stop.
        reason: that the user gives.
        unheard: what follows if no robot hears it.
        unsure: what follows if not all robots confirm it.

    Raises:
        SwarmError: in these cases.
    """
    from hitab_client import RosLink, SwarmError
    from hitab_core import quantity, some
    from hitab_ros import EmergencySwitch

    by = getpass.getuser()
    with ExitStack() as stack:
        ends = []
        numbers = _domains()
        for number in numbers:
            link = stack.enter_context(RosLink(number))
            switch = EmergencySwitch(link.node)
            switch.set(engaged, by, reason)
            ends.append((link, switch))
        domains = " and ".join(map(str, numbers))
        console.note(f"sent in ROS domain {domains}; waiting until the robots have confirmed")
        for link, switch in ends:
            _until_told(link, switch, engaged, by, reason)
        robots = sorted({robot for _, switch in ends for robot in _robots(switch)})
        others = sum(len(switch.listeners()) for _, switch in ends)
        late = [switch for _, switch in ends if not switch.delivered(DELIVER_S)]
    if not others:
        where = " or ".join(map(str, numbers))
        raise SwarmError(
            f"nobody heard it: no robot's relay runs in ROS domain {where}; {unheard}; check "
            "ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE with `hitab doctor`, and try again; "
            "for a simulated world, use `hitab world pause` and `hitab world resume`"
        )
    if late:
        raise SwarmError(
            f"not every robot has confirmed within {DELIVER_S:g} s (found: {some(robots)}); "
            f"{unsure}; then try again"
        )
    heard = some(robots) if robots else f"no robot, but {quantity(others, 'other node')} heard it"
    console.say(f"{done}: {heard}")


def _domains() -> list[int]:
    """Return the ROS domains that are meant: the user's, and those of all swarms that are up."""
    from hitab_client.domain_ids import chosen_by_user
    from hitab_client.run_folder import running_swarms

    return sorted({chosen_by_user() or 0} | {record.domain_id for _, record in running_swarms()})


def _until_told(
    link: RosLink, switch: EmergencySwitch, engaged: bool, by: str, reason: str
) -> None:
    """Stay until no more listeners are found; a latched message lasts as long as its sender."""
    known = 0

    def more() -> bool:
        nonlocal known
        if switch.engaged is not engaged:  # somebody's clock is ahead, and what it said counted
            switch.set(engaged, by, reason)
        before, known = known, len(switch.listeners())
        return known > before

    began = time.monotonic()
    link.spin_until(more, LOOK_S)
    while link.spin_until(more, LINGER_S) or (
        _lacks_relays(switch) and time.monotonic() < began + LOOK_S
    ):
        pass


def _lacks_relays(switch: EmergencySwitch) -> bool:
    """Whether something of a robot was found, such as its agent, but not yet its relay."""
    found = {node.rpartition("/")[0].removeprefix("/") for node in switch.listeners()}
    return bool(found - {""} - {*_robots(switch)})


def _robots(switch: EmergencySwitch) -> Iterator[str]:
    """Yield the robots whose relays listen."""
    from hitab_ros.names import VELOCITY_RELAY

    for node in switch.listeners():
        namespace, _, name = node.rpartition("/")
        if name == VELOCITY_RELAY:
            yield namespace.removeprefix("/") or name
