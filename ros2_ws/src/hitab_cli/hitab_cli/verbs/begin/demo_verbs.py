"""Verb that trains a team and plays: demo."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hitab_client import console
from hitab_client.terminal.cli_options import JsonPath


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
    distributes the learned behaviors; plays episodes. Takes one to two minutes.

    Args:
        out: Folder for pictures, results and the library.
        episodes: How many to play.
        seed: Random seed of the episodes.
        studio: Show the demo in a browser; the agents then play on.

    Examples:
      hitab demo --out my-demo
      hitab demo --studio
    """
    from hitab_cli.demo.training_demo import offered_demo, run_demo

    offered = offered_demo(name)
    studio_port = port if studio else None
    figures = run_demo(offered, out, episodes, seed, studio_port, browser=browser)
    console.write_json(json, figures)
