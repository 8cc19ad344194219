"""The verb that measures and keeps a demonstrator's reaction time."""

from __future__ import annotations

from typing import Annotated

import typer

from hitab_client import SwarmError, console, user_name
from hitab_core import Do


def reaction(
    seconds: Annotated[float | None, typer.Argument()] = None,
    measure: Annotated[bool, typer.Option("--measure")] = False,
    forget: Annotated[bool, typer.Option("--forget")] = False,
    demonstrator: Annotated[str, typer.Option(show_default=False)] = "",
) -> None:
    """Show, set or measure your reaction time; commands are then recorded as if they came in time.

    A person sees a situation, decides and presses a key: by then the situation has changed. With a
    reaction time kept, each command counts for the situation of that time before, scaled by the
    world's pace; while the world is paused, for the present one.

    Args:
        seconds: Your reaction time, s.
        measure: Measure it: a game of ten seconds.
        forget: Forget it; commands then count when they are given.
        demonstrator: The person whose time it is. Default: you.

    Examples:
      hitab reaction --measure
      hitab reaction 0.3
      hitab reaction --forget
    """
    from hitab_client import reaction_time

    who = demonstrator or user_name()
    if sum((seconds is not None, measure, forget)) > 1:
        raise typer.BadParameter("give a time, --measure or --forget, but only one of them")
    if measure:
        seconds = _measured()
    if seconds is not None or forget:
        reaction_time.keep(who, None if forget else seconds)
    now = reaction_time.of(who)
    console.say(
        f"commands of {who} count as given {now:g} s earlier"
        if now
        else f"{who} has no reaction time; each command counts when it is given"
    )


def _measured() -> float:
    import select
    import sys
    import time

    from hitab_client import reaction_time

    if not sys.stdin.isatty():
        raise SwarmError("the game needs a terminal with a keyboard", Do.MEASURE_REACTION())

    def pressed(seconds: float) -> float | None:
        if not select.select([sys.stdin], [], [], seconds)[0]:
            return None
        at = time.monotonic()
        sys.stdin.readline()
        return at

    console.note(f"Press Enter whenever it says NOW, {reaction_time.ROUNDS} times.")
    return reaction_time.measured(lambda: console.note("NOW"), pressed)
