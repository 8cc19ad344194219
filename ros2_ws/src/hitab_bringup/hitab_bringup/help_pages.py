"""How the help of all verbs looks, whichever package has declared them.

A docstring is written in lines of its file. Here its paragraphs become one line each, which the
terminal wraps at its own width, and so does each example. Its "Args:" are the help of arguments
and options.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.models import CommandInfo, DefaultPlaceholder

_ARGS = re.compile(r"^Args:\n((?: +.*\n?)+)\n?", re.MULTILINE)
_ARG = re.compile(r"^ {4}(\w+): (.*(?:\n {5,}.*)*)", re.MULTILINE)
_BELOW_ZERO = re.compile(r"-\.?[0-9]")
_EXAMPLE = re.compile(r"\n(?= +hitab )")


class HelpfulCommand(TyperCommand):
    """A verb whose docstring has the help of its arguments and options."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the parameters, `--help` included."""
        parameters: list[Any] = super().get_params(ctx)
        told = _told_of_parameters(inspect.getdoc(self.callback) or "")
        for parameter in parameters:
            if getattr(parameter, "help", "") is None:
                parameter.help = told.get(parameter.name)
        return parameters

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the arguments that are left; a number below 0 is a value, not an option."""
        ctx.ignore_unknown_options |= any(map(_BELOW_ZERO.match, args))
        rest: list[str] = super().parse_args(ctx, args)
        return rest


class HelpfulGroup(TyperGroup):
    """Verbs that show their help if none of them is named: a question, not a mistake."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the verb and its arguments."""
        if not args and not ctx.resilient_parsing:
            args = ["--help"]
        rest: list[str] = super().parse_args(ctx, args)
        return rest


def make_helpful(app: typer.Typer) -> None:
    """Give all verbs of a command, also those in its groups, readable help pages."""
    for _, command in verbs(app):
        if command.help is None:  # groups outlive the command, and are not done twice
            doc = _EXAMPLE.sub("\n\n", _ARGS.sub("", inspect.getdoc(command.callback) or ""))
            command.help = "\n\n".join(
                part if part.startswith(" ") else " ".join(part.split())
                for part in doc.split("\n\n")
            )
        if command.cls in (None, TyperCommand):
            command.cls = HelpfulCommand
    for group in app.registered_groups:
        inner = group.typer_instance
        if inner is not None and isinstance(inner.info.cls, DefaultPlaceholder):
            inner.info.cls = HelpfulGroup


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


def _told_of_parameters(doc: str) -> dict[str, str]:
    """Return the help of each parameter that a docstring has under "Args:"."""
    section = _ARGS.search(doc)
    found = _ARG.findall(section[1]) if section else ()
    return {name: " ".join(text.split()) for name, text in found}
