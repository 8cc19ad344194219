"""Options and arguments that several verbs share."""

from __future__ import annotations

from typing import Annotated

import typer

from hitab_client import completion

AgentName = Annotated[
    str,
    typer.Argument(help="Name of the agent, such as keeper_1.", autocompletion=completion.agents),
]
SwarmName = Annotated[
    str | None,
    typer.Option(
        "--swarm",
        envvar="HITAB_SWARM",
        help="The swarm, if several are up: its name, identity, namespace or run folder.",
        show_default=False,
        autocompletion=completion.swarms,
    ),
]
JsonPath = Annotated[
    str | None,
    typer.Option(
        "--json",
        metavar="PATH",
        help="Write the output as JSON to this file; - for stdout.",
        show_default=False,
    ),
]
