"""Plays trained keepers on a real rcssserver against UT Austin's takers at full speed.

The counterpart of `records.py` for the real simulator; collisions on. It needs two programs that
are not part of this project: rcssserver 19 and the `keepaway_player` of UT Austin's keepaway 0.6.

research/records_on_rcssserver.py --player keepaway_player --episodes 20
research/records_on_rcssserver.py --player keepaway_player --sight full --game 4v3 --side 25
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Annotated

import typer
from games import size_of
from rcss_programs import (
    PATIENCE_SECONDS,
    join,
    options,
    start,
    start_team,
    tell_episodes,
    tell_lost_commands,
)
from records import TRAINED_AWAY, trained_team

from hitab_bringup import players_of
from hitab_bringup.casting import CastMember
from hitab_bringup.libraries.opened_library import open_library
from hitab_client.runs.shipped import shipped
from hitab_core import Term
from hitab_rcssserver.rcss_world import RcssWorld
from hitab_rcssserver.server_settings import settings_from_dict
from hitab_world.inprocess import play

NOISY, FULL = SIGHTS = ("noisy", "full")
VISIBLE_ANGLE = {  # degrees
    FULL: 360,  # as for UT's keepers; it does not matter
    NOISY: 541,  # our keepers see all around them in every cycle
}


def main(
    player: Annotated[Path, typer.Option(help="UT Austin's program keepaway_player.")],
    server: Annotated[str, typer.Option(help="The rcssserver program.")] = "rcssserver",
    sight: Annotated[
        str, typer.Option(help="noisy: all see what the server shows; full: everything.")
    ] = NOISY,
    game: Annotated[str, typer.Option(help="Keepers against takers, as in 4v3.")] = "3v2",
    side: Annotated[int, typer.Option(help="Of the square box, m.", min=10)] = 20,
    episodes: Annotated[int, typer.Option(help="How many.", min=2)] = 20,
    port: Annotated[int, typer.Option(help="Port of the server.")] = 6600,
    away: Annotated[
        str, typer.Option(help="Word of a keeper whose ball it is not.")
    ] = TRAINED_AWAY,
    library: Annotated[Path | None, typer.Option(help="Folder of a trained library.")] = None,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Play episodes and print hold time, passes and how they ended; Ctrl-C prints those so far."""
    if sight not in SIGHTS:
        raise typer.BadParameter(f'there is no "{sight}" (known: {", ".join(SIGHTS)})')
    counts = size_of(game)
    full = sight == FULL
    settings, figures = settings_from_dict(
        {
            "port": port,
            "our_takers": False,
            "kick_off": True,
            "percepts": "fullstate" if full else "see",
            "sight": "full" if full else "quantised",
            "keepers": counts[0],
            "takers": counts[1],
        }
    )
    opened = open_library(library or shipped("libraries", "keepaway_fullspeed"))
    trained = CastMember(trained_team(opened, away), Term("Keepaway"))
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        start(
            stack,
            folder,
            server,
            *options(port, folder, full, side, {"visible_angle": VISIBLE_ANGLE[sight]}),
        )
        world = stack.enter_context(
            closing(RcssWorld(settings, figures, patience=PATIENCE_SECONDS))
        )
        join(world)
        start_team(stack, folder, player, port, counts, "takers")
        played = []
        players = players_of(world, dict.fromkeys(world.agents, trained))
        try:
            for number in range(episodes):
                played += play(world, players, 1, first=number)
                seconds = played[-1].seconds
                print(f"  episode {number + 1} of {episodes}: {seconds:.1f} s", flush=True)
        except KeyboardInterrupt:
            print("  interrupted; these are the figures so far")
        tell_lost_commands(folder)
    if not played:
        raise typer.Abort
    tell_episodes(
        f"trained keepers on rcssserver, {game} in {side} m, {sight}",
        [one.seconds for one in played],
        [one.measures["passes"] for one in played],
        sum(one.ended == "out" for one in played),
        json,
    )


if __name__ == "__main__":
    typer.run(main)
