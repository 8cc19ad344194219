"""Verb for demonstrating by keys, drive, and the functions that similar verbs share."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import SwarmError, completion, console
from hitab_client.terminal.cli_options import SwarmName
from hitab_core import Fix, HitabError, natural
from hitab_ros.timing import AT_ONCE_S, PROMPT_S, REPEAT_S

if TYPE_CHECKING:
    from rich.text import Text

    from hitab_client.demonstrating import Demonstrator

FirstAgent = Annotated[
    str,
    typer.Argument(
        help="Whom to command first. Default: the first agent.",
        show_default=False,
        autocompletion=completion.agents,
    ),
]


def drive(
    agent: FirstAgent = "", speed: float = 0.2, turn: float = 0.8, swarm: SwarmName = None
) -> None:
    """Train with one key per behavior, and drive robots by hand, in the terminal.

    A key commands a behavior at once, since one process stays connected; the studio has the same
    keys. Begin the training with `hitab train`. Arrow keys drive a robot with standard messages
    into place, through the relay that limits and stops it; its agent performs nothing meanwhile.
    The space bar is the emergency stop of all robots. Press ? for all keys.

    Args:
        speed: Speed of the arrow keys, m/s; the robot's own limits apply, too.
        turn: Turn rate of the arrow keys, rad/s.

    Examples:
      hitab drive
      hitab drive robot_1 --speed 0.1
    """
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise SwarmError(
            "driving needs a terminal with a keyboard; a gamepad does without",
            *(way(agent=agent) for way in (Fix.DEMONSTRATE, Fix.PERFORM) if agent),
        )
    for name, value in (("--speed", speed), ("--turn", turn)):
        if not 0.0 < value <= 10.0:
            raise typer.BadParameter(f"{name} is {value:g}; it must be above 0 and at most 10")
    with connection(swarm) as swarm_up:
        _drive(swarm_up, agent, speed, turn)


def _drive(swarm_up: Connection, agent: str, speed: float, turn: float) -> None:
    from rich.console import Group
    from rich.live import Live

    from hitab_cli.views.driving_view import lines
    from hitab_cli.views.terminal_keys import END, TerminalKeys
    from hitab_client.demonstrating import KeyboardInput

    demonstrator = demonstrator_of(swarm_up, agent, asks=True)
    keyboard = KeyboardInput(demonstrator, speed, turn)
    signs = swarm_up.agents.signs_of_life()
    ended = help_wanted = False
    before: list[Text] = []
    with (
        TerminalKeys(sys.stdin.fileno()) as keys,
        Live(console=console.out(), auto_refresh=False) as live,
    ):

        def tick() -> None:
            nonlocal ended, help_wanted, before
            for key in keys.read():
                if key == END:
                    ended = True
                elif key == "?":
                    help_wanted = not help_wanted
                else:
                    keyboard.press(key)
            now = list(lines(demonstrator, signs.silent(), help_wanted=help_wanted))
            if now != before:
                before = now
                live.update(Group(*now), refresh=True)

        carry_out(swarm_up, demonstrator, tick, lambda: ended)


def demonstrator_of(swarm_up: Connection, agent: str, *, asks: bool) -> Demonstrator:
    """Return a demonstrator who commands the named agent, or else the first one.

    Raises:
        SwarmError: if there is no such agent, or no agent at all.
    """
    from hitab_client.demonstrating import Demonstrator, behavior_keys

    agents, world = swarm_up.agents, swarm_up.world
    if agent:
        agents.await_agent(agent)
    else:
        names = agents.await_agents()
        if not names:
            raise SwarmError("no agent answers", Fix.STATUS())
        agent = min(names, key=natural)
    swarm_up.await_world()
    demonstrator = Demonstrator(
        agents, world, asks=asks, keys=behavior_keys.Keys(behavior_keys.file())
    )
    demonstrator.choose(agent)
    return demonstrator


def carry_out(
    swarm_up: Connection,
    demonstrator: Demonstrator,
    tick: Callable[[], None],
    ended: Callable[[], bool],
) -> None:
    """Carry out pressed keys until the person ends the program.

    Args:
        swarm_up: the connection.
        demonstrator: the person.
        tick: called periodically, also while waiting for an agent.
        ended: returns whether to end.
    """
    from hitab_ros import steady_timer

    steady_timer(swarm_up.link.node, AT_ONCE_S, tick)
    look_at = 0.0
    try:
        while not ended():
            swarm_up.link.spin(AT_ONCE_S)
            demonstrator.work()
            if time.monotonic() >= look_at:
                try:
                    demonstrator.look()
                except HitabError as error:
                    demonstrator.tell(str(error), failed=True)
                    look_at = time.monotonic() + REPEAT_S
    finally:
        demonstrator.close(PROMPT_S)
