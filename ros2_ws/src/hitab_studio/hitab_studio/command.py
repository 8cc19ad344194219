"""The verb that opens the demonstrator's console in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hitab_client import console
from hitab_client.terminal.cli_options import SwarmName


def register(app: typer.Typer) -> None:
    """Add the verb to the command."""
    app.command(rich_help_panel="Begin here")(studio)


def studio(
    swarm: Annotated[str | None, typer.Argument(envvar="HITAB_SWARM")] = None,
    chosen: SwarmName = None,
    port: Annotated[int, typer.Option(min=1, max=65535)] = 8080,
    host: str = "127.0.0.1",
    token: Annotated[str, typer.Option(show_default=False)] = "",
    allow_host: Annotated[list[str] | None, typer.Option(metavar="NAME")] = None,
    root_path: Annotated[str, typer.Option(show_default=False, metavar="PATH")] = "",
    browser: bool = True,
    run_dir: Path | None = None,
    map_topic: Annotated[str, typer.Option("--map", show_default=False, metavar="TOPIC")] = "",
    camera: Annotated[list[str] | None, typer.Option(show_default=False, metavar="TOPIC")] = None,
) -> None:
    """Open the console in a browser: the live field, training by clicking, learned behaviors.

    The swarm may be started before or after this command; the page finds it, also after a
    restart.

    Args:
        swarm: The swarm, if several are up: its name, identity, namespace or run folder.
        port: Where to serve the page.
        host: Address to serve it at; only this machine reaches 127.0.0.1.
        token: Required to open the page from other machines; generated if not given.
        allow_host: Another name by which the page may be opened, such as that of a proxy.
            Repeatable.
        root_path: Where a proxy shows the page, such as /hitab.
        browser: Open a browser.
        run_dir: The run folder of the swarm, instead of its name.
        map_topic: Of real robots: the topic of the map, if there are several.
        camera: Of real robots: the topic of a camera, or how it ends, if a robot has several.
            Repeatable.

    Examples:
      hitab studio
      hitab studio keepaway --port 9000 --no-browser
      hitab studio --host 0.0.0.0     for other machines, with a token
      hitab studio --allow-host lab.example.org --root-path /hitab     behind a proxy
      hitab studio --camera front/image/compressed --map /map     of real robots
    """
    from hitab_studio.access import new_token
    from hitab_studio.robots.topics import Options
    from hitab_studio.server import Address, serve
    from hitab_studio.swarm.launcher import startable_swarms, unknown
    from hitab_studio.swarm.swarm_finder import Finder

    root = f"/{root_path.strip('/')}" if root_path.strip("/") else ""
    address = Address(host, port, new_token(host, token), tuple(allow_host or ()), root)
    address.check()

    def ready() -> None:
        console.note(f"The studio is at {address.url}\nCtrl-C ends it.")

    name = swarm or chosen
    find = Finder(name, run_dir)
    target = find()
    if target.problem and target.swarm and (why := unknown(target.swarm)):
        console.note(f"{target.problem} {why}")
    serve(
        find,
        address,
        startable={} if run_dir else startable_swarms(name),
        show=browser,
        ready=ready,
        options=Options(map_topic, tuple(camera or ())),
    )
