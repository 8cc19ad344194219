"""Plays half-field attack on a real rcssserver, with the teams of `half_field.py`.

Against the defenders and the goalie of the simulated game, or against those of helios-base. It
needs rcssserver 19, which is not part of this project, and for --helios a helios-base that was
built as its README says. Each block of episodes is played on a server of its own; they begin as in
the simulated game of the same seed, but the server draws its own noise.

    scripts/python research/half_field_on_rcssserver.py compare --resume server.jsonl
    scripts/python research/half_field_on_rcssserver.py compare --helios helios-base/src
    scripts/python research/half_field_on_rcssserver.py search --helios helios-base/src
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack, closing
from itertools import product
from pathlib import Path
from typing import Annotated

import typer
from finished_runs import FinishedRuns, Resume
from half_field import BLOCK, Team, play_with, tell_teams, try_numbers
from rcss_programs import PATIENCE_SECONDS, given, join, options, start

from half_field_world import domain
from half_field_world.game import rules_of
from half_field_world.parameters import HalfFieldParameters
from hitab_rcssserver.rcss_world import RcssWorld
from hitab_rcssserver.server_settings import ServerSettings
from hitab_world import EpisodeResult

app = typer.Typer(add_completion=False, help=__doc__)
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


Helios = Annotated[Path | None, typer.Option(help="helios-base's folder src, built.")]
Server = Annotated[str, typer.Option(help="The rcssserver program.")]
Options = Annotated[
    list[str] | None, typer.Option(help="Another server option, as server::NAME=VALUE.")
]
Port = Annotated[int, typer.Option(help="Port of the server.")]
Touch = Annotated[float, typer.Option(help="Speed of the ball in a dribble, m/cycle.")]


def played(
    team: Team,
    seed: int,
    block: range,
    helios: Path | None,
    server: str,
    port: int,
    option: list[str] | None,
) -> list[EpisodeResult]:
    """Play some episodes with a team, on a server that is started for them."""
    match = {"keepaway": 0, "keepaway_logging": 0, "text_logging": 0, "fullstate_r": 0}
    others: dict[str, object] = {**match, "coach_w_referee": 1, **given(option)}
    parameters = HalfFieldParameters()
    settings = ServerSettings(
        port=port,
        trainer_port=port + 1,
        team="attackers",
        taker_team=HELIOS if helios else "defenders",
        our_takers=helios is None,
    )
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


@app.command()
def compare(
    helios: Helios = None,
    server: Server = "rcssserver",
    episodes: Annotated[int, typer.Option(help="Of each team.", min=2)] = 100,
    seed: Annotated[int, typer.Option(help="Of the episodes' beginnings.")] = 80_217,
    only: Annotated[list[str] | None, typer.Option(help="Only these teams.")] = None,
    option: Options = None,
    touch: Touch = domain.TOUCH,
    port: Port = 6700,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    resume: Resume = "",
) -> None:
    """Have all teams play the same episodes."""
    same = {"seed": seed, "block": BLOCK, "helios": helios is not None, "options": option or []}
    finished = FinishedRuns(resume, {**same, "touch": touch})
    vars(domain)["TOUCH"] = touch

    def play(team: Team, block: range) -> list[EpisodeResult]:
        return played(team, seed, block, helios, server, port, option)

    tell_teams(play, episodes, only, finished, json)


@app.command()
def search(
    helios: Helios = None,
    server: Server = "rcssserver",
    episodes: Annotated[int, typer.Option(help="Of each choice.", min=2)] = 40,
    seed: Annotated[int, typer.Option(help="Of the episodes; not that of `compare`.")] = 5,
    option: Options = None,
    touch: Touch = domain.TOUCH,
    port: Port = 6700,
) -> None:
    """Try other numbers for the rules."""
    vars(domain)["TOUCH"] = touch
    choices = product((6.0, 10.0, 15.0, 25.0), (-8.0, -4.0), (18.0,), (0.0, 1.5), (12.0,))
    try_numbers(
        lambda team: played(team, seed, range(episodes), helios, server, port, option), choices
    )


if __name__ == "__main__":
    app()
