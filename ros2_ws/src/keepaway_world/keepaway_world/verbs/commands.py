"""The verbs under `hitab keepaway`, and `hitab demo`."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated, Any

import typer

from hitab_client import console
from hitab_client.command_options import JsonPath, SwarmName

app = typer.Typer(help="Keepaway soccer: evaluate keepers, draw and film the field.")

Episodes = Annotated[int, typer.Option("--episodes", "-n", help="Number of episodes.", min=1)]
Seed = Annotated[
    int, typer.Option(help="Seed of the run; the same seed gives the same episodes.", min=0)
]
TakerSpeed = Annotated[float, typer.Option(help="Part of full speed; the paper: 0.25.", min=0.0)]
Library = Annotated[
    str | None,
    typer.Option(
        "--library",
        "-l",
        metavar="LIBRARY",
        help="A folder, SWARM/LIBRARY, or the name of a shipped library. Default: the shipped "
        "keepaway.",
    ),
]
Keepers = Annotated[
    str,
    typer.Option(
        help="trained; or others, for comparison: UT Austin's are called hand (hand-coded), "
        "rand (random passes) and hold, and come with research/src/keepaway_research."
    ),
]
Collisions = Annotated[
    bool | None,
    typer.Option(
        "--collisions/--no-collisions",
        help="Whether players collide with the ball and with each other.",
    ),
]
Behavior = Annotated[str, typer.Option(help="The keepers' top-level behavior.")]
Parameters = Annotated[
    list[str] | None,
    typer.Option(
        "--parameter",
        "--set",
        metavar="NAME=VALUE",
        help="Another parameter of the game. Repeatable.",
    ),
]


def register(app: typer.Typer) -> None:
    """Add `hitab demo`."""
    app.command(rich_help_panel="Begin here")(demo)


def _library(given: str | None) -> Path:
    """Return the folder of the library that is meant."""
    from hitab_bringup import named_library
    from hitab_client.shipped import shipped

    return named_library(given) if given else shipped("libraries", "keepaway")


@app.command()
def evaluate(
    library: Library = None,
    episodes: Episodes = 200,
    taker_speed: TakerSpeed = 0.25,
    seed: Seed = 1,
    pace: Annotated[
        str | None,
        typer.Option(
            help="lockstep: a process per keeper, over ROS; inprocess: without ROS. "
            "Default for trained keepers: lockstep."
        ),
    ] = None,
    keepers: Keepers = "trained",
    collisions: Collisions = None,
    world: Annotated[
        str,
        typer.Option(help="keepaway: the simulated world; rcssserver: a running RoboCup server."),
    ] = "keepaway",
    host: Annotated[str, typer.Option(help="Host of the rcssserver.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port of the rcssserver for players.")] = 6000,
    behavior: Behavior = "Keepaway",
    parameter: Parameters = None,
    plot: Annotated[
        Path | None, typer.Option(help="File for a plot of the episode lengths, PNG or SVG.")
    ] = None,
    json: JsonPath = None,
) -> None:
    """Play episodes with trained keepers and sum up how long they keep the ball.

    Examples:
      hitab keepaway evaluate --episodes 50
      hitab keepaway evaluate -l hitab-demo/library --json figures.json
      hitab keepaway evaluate --taker-speed 1.0 --parameter sight=full
      hitab keepaway evaluate --world rcssserver --port 6000 --episodes 20
      hitab keepaway evaluate --keepers hand --taker-speed 1.0 --set kick_noise=0
    """
    from keepaway_world.verbs.evaluation import PACES, RCSSSERVER, TRAINED, WORLDS
    from keepaway_world.verbs.evaluation import evaluate as play
    from keepaway_world.verbs.evaluation import evaluate_offered as play_offered

    pace = pace or (PACES[0] if keepers == TRAINED else PACES[1])
    for what, given, known in (("pace", pace, PACES), ("world", world, WORLDS)):
        if given not in known:
            raise typer.BadParameter(f'{what} "{given}" is not one of {", ".join(known)}')
    if keepers != TRAINED and (pace != "inprocess" or world == RCSSSERVER):
        raise typer.BadParameter(
            f"{keepers} keepers read the simulated field directly and have no node: they "
            "play in-process in the world keepaway; leave out --pace and --world"
        )
    parameters = _game(taker_speed, collisions, parameter)
    if world == RCSSSERVER:
        parameters |= {"host": host, "port": port}
    with console.progress("evaluating", "episodes") as advance:
        if keepers == TRAINED:
            evaluation = play(
                _library(library),
                behavior=behavior,
                episodes=episodes,
                seed=seed,
                pace=pace,
                parameters=parameters,
                advance=advance,
                world=world,
            )
        else:
            evaluation = play_offered(
                keepers, episodes=episodes, seed=seed, parameters=parameters, advance=advance
            )
    figures = evaluation.to_json()
    if json != "-":
        console.say(summary(figures))
    if plot is not None:
        from keepaway_world.verbs.evaluation import draw_episode_lengths

        draw_episode_lengths(evaluation, plot)
        console.note(f"plot in {plot}")
    console.write_json(json, figures)


def _game(taker_speed: float, collisions: bool | None, texts: list[str] | None) -> dict[str, Any]:
    """Return the parameters of a game that these options are about."""
    from hitab_bringup import figures_in

    parameters = {"taker_speed": taker_speed, **figures_in(texts or [])}
    if collisions is not None:
        parameters |= {"ball_collides": collisions, "players_collide": collisions}
    return parameters


def summary(figures: dict[str, Any]) -> str:
    """Return an evaluation in words."""
    hold, passes, ended = figures["hold_time_s"], figures["passes"], figures["ended"]
    missed = figures["missed_deadlines"]
    lines = [
        f"hold time  {hold['mean']:.2f} ± {hold['se']:.2f} s",
        f"passes     {passes['mean']:.2f} ± {passes['se']:.2f}",
        f"episodes   {figures['episodes']}: "
        + ", ".join(f"{count} {how}" for how, count in ended.items()),
        f"speed      {figures['cycles']} cycles in {figures['wall_s']:.1f} s "
        f"({figures['cycles_per_s']:.0f} cycles/s, {figures['pace']}), "
        f"{missed} missed deadline{'' if missed == 1 else 's'}",
    ]
    return "\n".join(lines)


@app.command()
def picture(
    path: Annotated[Path, typer.Argument(help="File for the picture, PNG or SVG.")],
    swarm: SwarmName = None,
) -> None:
    """Draw the current field of the swarm that is up.

    Example:
      hitab keepaway picture field.png
    """
    from hitab_bringup import connection
    from keepaway_world.verbs.field_picture import draw_field

    with connection(swarm) as swarm_up:
        swarm_up.world.wait()
        state = swarm_up.world.state_at(0)
    draw_field([state.entities], state.width, state.height, path)
    console.say(f"drawn to {path}")


@app.command()
def film(
    path: Annotated[Path, typer.Argument(help="File for the film: GIF, PNG (animated) or WebP.")],
    library: Library = None,
    taker_speed: TakerSpeed = 0.25,
    seed: Seed = 1,
    episode: Annotated[int, typer.Option(help="Number of the episode in the run.", min=0)] = 0,
    begin: Annotated[float, typer.Option(help="s, when the film begins.", min=0.0)] = 0.0,
    seconds: Annotated[float, typer.Option(help="s, how long it takes.", min=0.1)] = 20.0,
    speed: Annotated[
        float, typer.Option(help="Of the film, as a factor of real time.", min=0.1, max=10.0)
    ] = 1.0,
    pixels: Annotated[int, typer.Option(help="Width of the pictures.", min=100, max=2000)] = 360,
    keepers: Keepers = "trained",
    collisions: Collisions = None,
    behavior: Behavior = "Keepaway",
    parameter: Parameters = None,
) -> None:
    """Film an episode, which is played without ROS.

    It is the episode that `evaluate` plays with the same options.

    Examples:
      hitab keepaway film paper.gif --seconds 10
      hitab keepaway film hand.webp --keepers hand --seed 3 --episode 7
    """
    from hitab_bringup import part_of
    from keepaway_world.verbs.evaluation import TRAINED, offered_game, trained_game
    from keepaway_world.verbs.field_film import check_film, draw_film
    from keepaway_world.verbs.field_film import film as play

    check_film(path)
    parameters = _game(taker_speed, collisions, parameter)
    with console.progress("filming", "pictures") as advance, contextlib.ExitStack() as stack:
        if keepers == TRAINED:
            trained = part_of(_library(library), behavior)
            world, players = stack.enter_context(trained_game(trained, parameters, seed))
        else:
            world, players = offered_game(keepers, parameters, seed)
        filmed = play(world, players, episode, begin, seconds)
        draw_film(filmed, *world.size, path, advance, pixels=pixels, speed=speed)
    how = f"; the episode ended: {filmed.ended}" if filmed.ended else ""
    size = path.stat().st_size / 1000.0
    console.say(f"filmed {filmed.seconds:.1f} s to {path}, {size:.0f} kB{how}")


def demo(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for pictures, results and the library.")
    ] = Path("hitab-demo"),
    episodes: Episodes = 200,
    seed: Seed = 1,
    json: JsonPath = None,
    studio: Annotated[
        bool, typer.Option("--studio", help="Watch it in a browser; the keepers play on.")
    ] = False,
    port: Annotated[int, typer.Option(help="Port of the studio.")] = 8080,
    browser: Annotated[bool, typer.Option(help="Open a browser.")] = True,
) -> None:
    """Train three keepers over ROS topics, play, and compare with the paper on this method.

    Starts a world and three keepers, each in its own process; plays the four lessons from an empty
    library; distributes what was learned; plays episodes against slow takers. Takes one to two
    minutes.

    Examples:
      hitab demo --out my-demo
      hitab demo --studio
    """
    from keepaway_world.verbs.demo import run_demo

    figures = run_demo(out, episodes, seed, port if studio else None, browser=browser)
    console.write_json(json, figures)
