"""Layout of the help pages of all verbs, of any package.

Each paragraph of a verb's docstring becomes one line, which the terminal wraps at its own width.
The section "Args:" is the help of arguments and options; a verb made from an operation adds the
operation's section "Attributes:".
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import typer
from typer.core import TyperCommand
from typer.models import CommandInfo

_ARGS = re.compile(r"^(Args|Attributes):\n((?: +.*\n?)+)\n?", re.MULTILINE)
_ARG = re.compile(r"^ {4}(\w+): (.*(?:\n {5,}.*)*)", re.MULTILINE)
_BELOW_ZERO = re.compile(r"-\.?[0-9]")
_BREAK = re.compile(r"(?<!\n)\n(?=\S)")
"""Pattern between two lines of a paragraph; indented examples stay on lines of their own."""


class HelpfulCommand(TyperCommand):
    """Verb whose docstring contains the help of its arguments and options."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the parameters, `--help` included."""
        parameters: list[Any] = super().get_params(ctx)
        helps = _parameter_helps(inspect.getdoc(self.callback) or "")
        for parameter in parameters:
            if getattr(parameter, "help", "") is None:
                parameter.help = helps.get(parameter.name)
        return parameters

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the remaining arguments; a number below 0 is a value, not an option."""
        ctx.ignore_unknown_options |= any(map(_BELOW_ZERO.match, args))
        rest: list[str] = super().parse_args(ctx, args)
        return rest


def make_helpful(app: typer.Typer) -> None:
    """Give all verbs of a command and of its groups readable help pages."""
    for _, command in verbs(app):
        if command.help is None:  # groups outlive the command, and may be ready already
            doc = inspect.getdoc(command.callback) or ""
            command.help = _BREAK.sub(" ", _ARGS.sub("", doc))
        command.cls = HelpfulCommand


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


def _parameter_helps(doc: str) -> dict[str, str]:
    """Return the help of each parameter in a docstring; the first section that has it counts."""
    found = {}
    for title, section in reversed(_ARGS.findall(doc)):
        for name, text in _ARG.findall(section):
            told = " ".join(text.split())
            if title == "Attributes":
                told = told[0].upper() + told[1:].replace("``", "").replace(
                    "; empty for ", ". Default: "
                )
            found[name] = told
    return found
