"""The verbs that show what agents learn and play: demo, film."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hitab_client import completion, console
from hitab_client.cli_options import JsonPath


def demo(
    name: Annotated[str, typer.Argument(help="Of the demo. Default: the first one.")] = "",
    out: Annotated[Path, typer.Option("--out", "-o")] = Path("hitab-demo"),
    episodes: Annotated[int, typer.Option("--episodes", "-n", min=1)] = 200,
    seed: Annotated[int, typer.Option(min=0)] = 1,
    json: JsonPath = None,
    studio: Annotated[bool, typer.Option("--studio")] = False,
    port: Annotated[int, typer.Option(help="Port of the studio.")] = 8080,
    browser: Annotated[bool, typer.Option(help="Open a browser.")] = True,
) -> None:
    """Train a team over ROS topics, play, and compare with the paper on this method.

    Starts a world and agents, each in its own process; plays lessons from an empty library;
    distributes what was learned; plays episodes. Takes one to two minutes.

    Args:
        out: Folder for pictures, results and the library.
        episodes: How many to play.
        seed: The same seed gives the same episodes.
        studio: Watch it in a browser; the agents play on.

    Examples:
      hitab demo --out my-demo
      hitab demo --studio
    """
    from hitab_cli.demo.training_demo import offered_demo, run_demo

    offered = offered_demo(name)
    port_meant = port if studio else None
    figures = run_demo(offered, out, episodes, seed, port_meant, browser=browser)
    console.write_json(json, figures)


def film(
    swarm: Annotated[str, typer.Argument(autocompletion=completion.swarm_descriptions)],
    path: Annotated[Path, typer.Argument(metavar="FILE")],
    library: Annotated[
        list[str] | None, typer.Option("--library", "-l", metavar="[AGENT=]LIBRARY")
    ] = None,
    behavior: Annotated[
        list[str] | None, typer.Option("--behavior", "-b", metavar="[AGENT=]BEHAVIOR")
    ] = None,
    seed: Annotated[int, typer.Option(min=0)] = 1,
    episode: Annotated[int, typer.Option(min=0)] = 0,
    begin: Annotated[float, typer.Option(min=0.0)] = 0.0,
    seconds: Annotated[float, typer.Option(min=0.1)] = 20.0,
    speed: Annotated[float, typer.Option(min=0.1, max=10.0)] = 1.0,
    pixels: Annotated[int, typer.Option(min=100, max=2000)] = 360,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", "--set", metavar="NAME=VALUE")
    ] = None,
) -> None:
    """Film an episode of a swarm, which is played without ROS.

    It is the episode that `hitab evaluate` plays with the same options.

    Args:
        swarm: A swarm description, or the name of a shipped one; it need not be up.
        path: File for the film: GIF, PNG (animated) or WebP.
        library: As of `hitab evaluate`. Repeatable.
        behavior: As of `hitab evaluate`. Repeatable.
        seed: Of the run.
        episode: Number of the episode in the run.
        begin: Simulated seconds after which the film begins.
        seconds: How long it takes.
        speed: Of the film, as a factor of real time.
        pixels: Width of the pictures.
        parameter: A figure of the world. Repeatable.

    Examples:
      hitab film keepaway_trained keepers.gif --seconds 10
      hitab film half_field attack.webp --seed 3 --episode 7
    """
    from hitab_bringup import Cast, evaluated_swarm, games_of
    from hitab_cli.views.field_film import check_film, draw_film
    from hitab_cli.views.field_film import film as play

    check_film(path)
    described = evaluated_swarm(swarm, seed, parameter or [])
    cast = Cast(described)
    cast.choose_libraries(library or [])
    cast.choose_behaviors(behavior or [])
    with games_of(described, [cast.parts()]) as games:
        filmed = play(games[0], episode, begin, seconds)
        with console.progress("filming", "pictures") as advance:
            draw_film(filmed, path, advance, pixels=pixels, speed=speed)
    how = f"; the episode ended: {filmed.ended}" if filmed.ended else ""
    size = path.stat().st_size / 1000.0
    console.say(f"filmed {filmed.seconds:.1f} s to {path}, {size:.0f} kB{how}")
