"""How the help of all verbs looks, whichever package has declared them."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any

import typer
from typer.core import TyperGroup
from typer.models import CommandInfo


class HelpfulGroup(TyperGroup):
    """Verbs that show their help if none of them is named: a question, not a mistake."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the verb and its arguments."""
        if not args and not ctx.resilient_parsing:
            args = ["--help"]
        rest: list[str] = super().parse_args(ctx, args)
        return rest


def make_helpful(app: typer.Typer) -> None:
    """Have the terminal wrap the help of all verbs, whose docstrings have lines of their own."""
    for _, command in verbs(app):
        if command.help is None:  # groups outlive the command, and are not done twice
            parts = inspect.getdoc(command.callback) or ""
            command.help = "\n\n".join(
                part if part.startswith(" ") else " ".join(part.split())
                for part in parts.split("\n\n")
            )


def verbs(
    app: typer.Typer, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], CommandInfo]]:
    """Yield all verbs of a command with the words that call them, such as ``world pause``."""
    for command in app.registered_commands:
        name = command.name or getattr(command.callback, "__name__", "").replace("_", "-")
        yield (*path, name), command
    for group in app.registered_groups:
        if group.typer_instance is not None:
            yield from verbs(group.typer_instance, (*path, str(group.name)))
