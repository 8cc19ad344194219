"""Plays half-field attack on a real rcssserver, with the teams of `half_field.py`.

Against the defenders and the goalie of the simulated game, or against those of helios-base. It
needs rcssserver 19, which is not part of this project, and for --helios a helios-base that was
built as its README says. Each block of episodes is played on a server of its own; they begin as in
the simulated game of the same seed, but the server draws its own noise.

    scripts/python research/half_field_on_rcssserver.py --resume server.jsonl --json server.json
    scripts/python research/half_field_on_rcssserver.py --helios helios-base/src --episodes 60
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Annotated

import typer
from finished_runs import FinishedRuns, Resume
from half_field import BLOCK, Team, play_with, tell_teams
from rcss_programs import PATIENCE_SECONDS, join, options, start

from hitab_world import EpisodeResult
from keepaway_world.half_field.game import rules_of
from keepaway_world.half_field.parameters import HalfFieldParameters
from keepaway_world.rcss.rcss_world import RcssWorld
from keepaway_world.rcss.server_settings import ServerSettings

HELIOS = "HELIOS_base"


def start_helios(stack: ExitStack, folder: Path, sources: Path, port: int) -> None:
    """Start the goalie of helios-base, and as many defenders as in our game.

    Args:
        stack, folder: see `start`.
        sources: the folder ``src`` of helios-base, where it was built.
        port: of the server.
    """
    sources = sources.resolve()
    arguments = f"--player-config {sources}/player.conf --config_dir {sources}/formations-dt"
    command = (str(sources / "sample_player"), *f"{arguments} -p {port} -t {HELIOS}".split())
    start(stack, folder, *command, "-g")
    start(stack, folder, *command, count=HalfFieldParameters().takers - 1)


def main(
    helios: Annotated[Path | None, typer.Option(help="helios-base's folder src, built.")] = None,
    server: Annotated[str, typer.Option(help="The rcssserver program.")] = "rcssserver",
    episodes: Annotated[int, typer.Option(help="Of each team.", min=2)] = 100,
    seed: Annotated[int, typer.Option(help="Of the episodes' beginnings.")] = 80_217,
    offside: Annotated[bool, typer.Option(help="With offside.")] = False,
    only: Annotated[list[str] | None, typer.Option(help="Only these teams.")] = None,
    port: Annotated[int, typer.Option(help="Port of the server.")] = 6700,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    resume: Resume = "",
) -> None:
    """Have all teams play the same episodes."""
    others = {"keepaway": 0, "keepaway_logging": 0, "text_logging": 0, "fullstate_r": 0}
    others |= {"coach_w_referee": 1, "use_offside": int(offside)}
    parameters = HalfFieldParameters()
    settings = ServerSettings(
        port=port,
        trainer_port=port + 1,
        team="attackers",
        taker_team=HELIOS if helios else "defenders",
        our_takers=helios is None,
    )

    def played(team: Team, block: range) -> list[EpisodeResult]:
        with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
            folder = Path(name)
            start(stack, folder, server, *options(port, folder, True, 20, others))
            world = RcssWorld(
                settings, parameters, seed, rules_of(parameters), patience=PATIENCE_SECONDS
            )
            stack.enter_context(closing(world))
            join(world)
            if helios:
                start_helios(stack, folder, helios, port)
            return play_with(team, world, block)

    finished = FinishedRuns(
        resume, {"seed": seed, "block": BLOCK, "offside": offside, "helios": helios is not None}
    )
    tell_teams(played, episodes, only, finished, json)


if __name__ == "__main__":
    typer.run(main)
