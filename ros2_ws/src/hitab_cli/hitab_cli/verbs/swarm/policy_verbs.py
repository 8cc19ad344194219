"""Verb that writes what the nodes of a swarm may do: policy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hitab_client import completion, console


def policy(
    swarm: Annotated[str, typer.Argument(autocompletion=completion.swarm_descriptions)],
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE")] = None,
    namespace: Annotated[str, typer.Option("--namespace", metavar="NAME")] = "",
) -> None:
    """Write a policy for SROS2: which topics and services each node of a swarm may use.

    ROS's own command `ros2 security` makes keys and permissions from it.

    Args:
        swarm: A swarm description, the name of a shipped one, or a Python file with a world.
        output: File to write. By default, print the policy.
        namespace: As for `hitab up`.

    Examples:
      hitab policy keepaway
      hitab policy field.yaml --output policy.xml
    """
    from hitab_bringup import described_swarm, security_policy

    text = security_policy(described_swarm(swarm, None, namespace=namespace))
    if output is None:
        typer.echo(text, nl=False)
    else:
        output.write_text(text, encoding="utf-8")
        console.say(f"wrote {output}")
