"""How the help of all verbs looks, whichever package has declared them.

A docstring is written in lines of its file. Here its paragraphs become one line each, which the
terminal wraps at its own width; its examples stay lines of their own. Its "Args:" are the help
of arguments and options.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Iterator
from functools import partial
from itertools import groupby
from typing import Any

import typer
from typer.core import TyperArgument, TyperCommand, TyperGroup, TyperOption
from typer.models import CommandInfo, DefaultPlaceholder

INDENT = "  "
"""Of examples."""

WORDS = {"int": "NUMBER", "float": "NUMBER", "path": "PATH", "str": "TEXT"}
"""What the help calls types; their names in Python tell a user nothing."""


_ARGS = re.compile(r"^Args:\n((?: +.*\n?)+)\n?", re.MULTILINE)
_ARG = re.compile(r"^ {4}(\w+): (.*(?:\n {5,}.*)*)", re.MULTILINE)


class HelpfulCommand(TyperCommand):
    """A verb whose help says what a user has to know of the types of its options."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the parameters, `--help` included."""
        parameters = _described(super().get_params(ctx))
        told = _told_of_parameters(inspect.getdoc(self.callback) or "")
        for parameter in parameters:
            if getattr(parameter, "help", "") is None:
                parameter.help = told.get(parameter.name)
        return parameters


class HelpfulGroup(TyperGroup):
    """Verbs that show their help if none of them is named: a question, not a mistake."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the parameters, `--help` included."""
        return _described(super().get_params(ctx))

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
            doc = inspect.getdoc(command.callback) or ""
            command.help = reflowed(_ARGS.sub("", doc))
        if command.cls in (None, TyperCommand):
            command.cls = HelpfulCommand
    for _, group in _groups(app):
        if isinstance(group.info.cls, DefaultPlaceholder):
            group.info.cls = HelpfulGroup


def verbs(app: typer.Typer) -> Iterator[tuple[tuple[str, ...], CommandInfo]]:
    """Yield all verbs of a command with the words that call them, such as ``world pause``."""
    for path, group in ((), app), *_groups(app):
        for command in group.registered_commands:
            name = command.name or getattr(command.callback, "__name__", "").replace("_", "-")
            yield (*path, name), command


def _groups(
    app: typer.Typer, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], typer.Typer]]:
    for group in app.registered_groups:
        inner = group.typer_instance
        if inner is not None and not isinstance(inner, DefaultPlaceholder):
            within = (*path, str(group.name))
            yield within, inner
            yield from _groups(inner, within)


def reflowed(text: str) -> str:
    r"""Return a help text with one line for each paragraph, and for each of its examples.

    Args:
        text: paragraphs; those that are indented are examples.

    Examples:
        >>> print(reflowed("Go\non.\n\nExamples:\n\n  one\n\n  two"))
        Go on.
        <BLANKLINE>
        Examples:
        <BLANKLINE>
        [none]  one[/none]
        [none]  two[/none]
    """
    return "\n\n".join(_parts(inspect.cleandoc(text)))


def _parts(text: str) -> Iterator[str]:
    paragraphs = [part for part in text.split("\n\n") if part.strip()]
    for is_example, together in groupby(paragraphs, lambda part: part.startswith(" ")):
        if not is_example:
            yield from (" ".join(part.split()) for part in together)
            continue
        lines = [
            line for part in together for line in textwrap.dedent(part).split("\n") if line.strip()
        ]
        # Typer removes the indentation of what begins with a space. Tags are not shown.
        yield "\n".join(f"[none]{INDENT}{line}[/none]" for line in lines)


def _told_of_parameters(doc: str) -> dict[str, str]:
    """Return the help of each parameter that a docstring has under "Args:"."""
    section = _ARGS.search(doc)
    found = _ARG.findall(section[1]) if section else ()
    return {name: " ".join(text.split()) for name, text in found}


def _described(parameters: list[Any]) -> list[Any]:
    for parameter in parameters:
        if isinstance(parameter, TyperArgument | TyperOption):
            words = _type_in_words(parameter)
            # Typer asks for these when it prints; it takes no words for a type otherwise.
            parameter.display_type_rich = partial(_said, words)  # type: ignore
            parameter._get_number_range_help_str = lambda: None  # type: ignore
    return parameters


def _said(words: str, ctx: Any) -> str:
    return words


def _type_in_words(parameter: TyperArgument | TyperOption) -> str:
    """Return what is to be given: nothing for a flag, or an argument, whose name tells it."""
    if isinstance(parameter, TyperOption) and parameter.metavar is not None:
        return parameter.metavar
    annotation = str(parameter.type_descriptor.annotation).lower()
    if isinstance(parameter, TyperOption) and parameter.is_flag:
        return ""
    word = next((word for name, word in WORDS.items() if name in annotation), "TEXT")
    if word == "TEXT" and isinstance(parameter, TyperArgument):
        return ""
    return f"{word}{_range(parameter.min, parameter.max)}"


def _range(least: float | None, most: float | None) -> str:
    if least is not None and most is not None:
        return f" {least:g} to {most:g}"
    if least is not None:
        return f" from {least:g}"
    return f" up to {most:g}" if most is not None else ""
