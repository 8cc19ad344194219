"""Verbs that play episodes without ROS: evaluate, film."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hitab_client import completion, console
from hitab_client.terminal.cli_options import JsonPath
from hitab_core import quantity

if TYPE_CHECKING:
    from hitab_bringup import CastMember, Comparison
    from hitab_client.measures import Estimate

LINES = 10
"""Number of lines of progress, if there is no bar."""

SwarmFile = Annotated[str, typer.Argument(autocompletion=completion.swarm_descriptions)]
Libraries = Annotated[list[str] | None, typer.Option("--library", "-l", metavar="[AGENT=]LIBRARY")]
Behaviors = Annotated[
    list[str] | None, typer.Option("--behavior", "-b", metavar="[AGENT=]BEHAVIOR")
]
Figures = Annotated[list[str] | None, typer.Option("--parameter", "--set", metavar="NAME=VALUE")]
Seed = Annotated[int, typer.Option(min=0)]


def evaluate(
    swarm: SwarmFile,
    library: Libraries = None,
    behavior: Behaviors = None,
    against: Annotated[list[str] | None, typer.Option(metavar="[AGENT=]LIBRARY|NAME@1")] = None,
    episodes: Annotated[int, typer.Option("--episodes", "-n", min=1)] = 50,
    seed: Seed = 1,
    longest: Annotated[float, typer.Option(min=0.0)] = 0.0,
    parameter: Figures = None,
    plot: Path | None = None,
    json: JsonPath = None,
) -> None:
    """Play episodes of a swarm without ROS, and summarize the measures of its world.

    With --against, each episode is played twice from the same beginning. The difference is
    `better` or `worse` if its 95 % interval does not contain 0. Commanders give orders as in the
    swarm, unless all agents are given a behavior. Ctrl-C ends the evaluation with the figures so
    far.

    Args:
        swarm: A swarm description, or the name of a shipped one; it need not be up.
        library: A folder, SWARM/LIBRARY of a swarm that was up, or a shipped library, for one
            agent or all. Repeatable. Default: the agents' present or initial libraries.
        behavior: The behavior of an agent or of all; `nothing` for none. Repeatable. Default: as
            in the description.
        against: Compare with another library, or with an earlier version of a behavior.
            Repeatable.
        episodes: Number of episodes.
        seed: Random seed of the episodes.
        longest: Longest episode, simulated seconds; 0 for no limit.
        parameter: Another value for a parameter of the world, NAME=VALUE. Repeatable.
        plot: File for a plot, PNG or SVG.

    Examples:
      hitab evaluate keepaway_trained -n 100 --plot hold.png
      hitab evaluate keepaway -b keeper_1=Chase --against Chase@1 --longest 30
      hitab evaluate half_field -n 200
      hitab evaluate foraging -l my_library --against foraging -n 5 --set foragers=20
    """
    from hitab_bringup import (
        SIDES,
        Cast,
        Comparison,
        evaluated_swarm,
        games_of,
        measures_of,
        play_alike,
    )

    described = evaluated_swarm(swarm, seed, parameter or [])
    cast = Cast(described, library, behavior)
    parts = [cast.parts()]
    if against:
        cast.choose_libraries(against)
        parts.append(cast.parts())
    played: list[Any] = []
    interrupted = False
    every = max(1, episodes // LINES)
    with games_of(described, parts) as games:
        try:
            with console.progress("evaluating", "episodes", line_every=every) as advance:
                advance(0, episodes, "")
                for results in play_alike(games, episodes, longest=longest):
                    played.append(results)
                    advance(len(played), episodes, "")
        except KeyboardInterrupt:
            interrupted = True
            console.note(f"interrupted; {quantity(len(played), 'episode')} of {episodes} played")
        measures = measures_of(games[0][0], [one for results in played for one in results])
    if not played:
        raise typer.Exit(130)
    compared = [Comparison.of(measure, played) for measure in measures]
    _show(described.name, parts, played, compared, seed, json)
    if plot is not None:
        from hitab_cli.views.plots import draw_measures

        draw_measures(
            {_named(one): dict(zip(SIDES, one.values, strict=False)) for one in compared},
            f"{described.name}: {quantity(len(played), 'episode')}, seed {seed}",
            plot,
        )
        console.note(f"plot in {plot}")
    if interrupted:
        raise typer.Exit(130)


def film(
    swarm: SwarmFile,
    path: Annotated[Path, typer.Argument(metavar="FILE")],
    library: Libraries = None,
    behavior: Behaviors = None,
    seed: Seed = 1,
    episode: Annotated[int, typer.Option(min=0)] = 0,
    begin: Annotated[float, typer.Option(min=0.0)] = 0.0,
    seconds: Annotated[float, typer.Option(min=0.1)] = 20.0,
    speed: Annotated[float, typer.Option(min=0.1, max=10.0)] = 1.0,
    pixels: Annotated[int, typer.Option(min=100, max=2000)] = 360,
    parameter: Figures = None,
) -> None:
    """Film an episode of a swarm that is played without ROS.

    The episode is the same as of `hitab evaluate` with the same options.

    Args:
        swarm: A swarm description, or the name of a shipped one; it need not be up.
        path: File for the film: GIF, PNG (animated) or WebP.
        library: As for `hitab evaluate`. Repeatable.
        behavior: As for `hitab evaluate`. Repeatable.
        seed: Random seed of the run.
        episode: Number of the episode in the run.
        begin: Beginning of the film in the episode, simulated seconds.
        seconds: Length of the filmed part, simulated seconds.
        speed: Speed of the film, as a factor of real time.
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
    with games_of(described, [Cast(described, library, behavior).parts()]) as games:
        filmed = play(games[0], episode, begin, seconds)
        with console.progress("filming", "pictures") as advance:
            draw_film(filmed, path, advance, pixels=pixels, speed=speed)
    how = f"; the episode ended: {filmed.ended}" if filmed.ended else ""
    size = path.stat().st_size / 1000.0
    console.say(f"filmed {filmed.seconds:.1f} s to {path}, {size:.0f} kB{how}")


def _named(one: Comparison) -> str:
    unit = one.measure.unit
    return f"{one.measure.name}, {unit}" if unit else one.measure.name


def _show(
    swarm: str,
    parts: Sequence[Mapping[str, CastMember]],
    played: Sequence[Any],
    compared: Sequence[Comparison],
    seed: int,
    json: str | None,
) -> None:
    from hitab_bringup import SIDES, endings

    both = len(parts) > 1
    columns = ["measure", "evaluated", *["against", "difference", ""] * both]
    rows = []
    for one in compared:
        cells = [_named(one), *map(_shown, one.estimates)]
        rows.append([*cells, *([_shown(one.difference), one.verdict] if both else [])])
    ended = dict(zip(SIDES, endings(played), strict=False))
    data = {
        "swarm": swarm,
        "episodes": len(played),
        "seed": seed,
        "agents": {key: _cast_data(one) for key, one in zip(SIDES, parts, strict=False)},
        "measures": {one.measure.name: one.to_json() for one in compared},
        "ended": ended,
    }
    lines = [
        f"{key}: {', '.join(f'{count} {how}' for how, count in counts.items())}"
        for key, counts in ended.items()
    ]
    title = f"{swarm}: {quantity(len(played), 'episode')}, seed {seed}; mean ± error [95 %]"
    console.show(json, data, title, console.table(columns, rows), *lines)


def _cast_data(parts: Mapping[str, CastMember]) -> dict[str, Any]:
    return {
        name: {
            "behavior": str(part.behavior or ""),
            "library": str(part.opened.folder) if part.opened else "",
            "digest": part.opened.digest if part.opened else "",
            "versions": dict(part.versions),
        }
        for name, part in parts.items()
    }


def _shown(found: Estimate) -> str:
    if found.mean is None:
        return "-"
    if found.se is None or found.low is None or found.high is None:
        return f"{found.mean:.4g}"
    return f"{found.mean:.4g} ± {found.se:.2g} [{found.low:.4g}, {found.high:.4g}]"
