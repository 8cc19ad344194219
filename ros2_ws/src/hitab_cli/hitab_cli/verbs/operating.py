"""Verbs made from operations: their arguments and options are the operations' fields."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, Field
from functools import partial
from typing import Annotated, Any

import typer

from hitab_cli.verbs.verb_connection import Connection, connection
from hitab_client import console
from hitab_client.terminal.cli_options import AgentName, SwarmName
from hitab_core.operations import MOMENT
from hitab_core.training.operation import Operation, is_required

_PARAMETERS: dict[str, Any] = {
    "behavior": typer.Argument(),
    "targets": typer.Argument(show_default=False),
    "numbers": typer.Argument(help="Numbers of examples, see `hitab examples`."),
    "next_state": typer.Option("--to"),
    "receivers": typer.Option("--to"),
    "features": typer.Option("--feature", "-f"),
    "automaton": typer.Option("--name"),
    "bindings": typer.Option("--bind", metavar="ball=A"),
    "keep_unused": typer.Option("--keep-unused/--no-keep-unused"),
}
"""Arguments, and options that do not have the name of their field, by field."""

_TYPES = {"bool": bool, "int": int, "float": float, "str": str, "Sequence[int]": list[int]}
"""Types of parameters, by those of fields; of other fields, a list of texts."""

_parameter = partial(inspect.Parameter, kind=inspect.Parameter.KEYWORD_ONLY)


def say_done(swarm_up: Connection, agent: str, operation: Operation) -> Any:
    """Have an agent carry out an operation; print its answer, and return it."""
    answer = swarm_up.agents.do(agent, operation)
    console.say_answer(answer)
    return answer


def operates(kind: type[Operation], *examples: str) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that makes a verb of a function that has an operation carried out.

    The function is called with the connection, the agent's name and the operation, and with its
    own further parameters, which follow those of the operation.

    Args:
        kind: the operation.
        examples: calls of the verb; its help is then the operation's docstring. Without examples,
            the help is the function's docstring.
    """
    asked = [f for name, f in kind.own_fields().items() if name not in MOMENT]

    def decorated(function: Callable[..., Any]) -> Any:
        def verb(agent: str, swarm: str | None, **given: Any) -> None:
            values = {field.name: given.pop(field.name) for field in asked}
            if "bindings" in values:
                values["bindings"] = bound(values["bindings"])
            with connection(swarm) as swarm_up:
                function(swarm_up, agent, kind(**values), **given)

        further = [*inspect.signature(function, eval_str=True).parameters.values()][3:]
        parameters = [
            _parameter("agent", annotation=AgentName),
            *map(_asked, asked),
            *(parameter.replace(kind=parameter.KEYWORD_ONLY) for parameter in further),
            _parameter("swarm", annotation=SwarmName, default=None),
        ]
        verb.__name__ = kind.name.partition("_")[0]
        verb.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        doc = inspect.getdoc(kind) or ""
        if examples:
            title = "Examples:" if len(examples) > 1 else "Example:"
            verb.__doc__ = "\n  ".join([f"{doc}\n\n{title}", *examples])
        else:
            fields = "".join(doc.partition("Attributes:")[1:])
            verb.__doc__ = f"{inspect.getdoc(function)}\n\n{fields}"
        return verb

    return decorated


def _asked(field: Field[Any]) -> inspect.Parameter:
    """Return the argument or option that asks for a field."""
    info = _PARAMETERS.get(field.name) or typer.Option(f"--{field.name}")
    annotation: Any = Annotated[_TYPES.get(str(field.type), list[str]), info]
    if is_required(field):
        return _parameter(field.name, annotation=annotation)
    default = () if field.default is MISSING else field.default
    return _parameter(field.name, annotation=annotation, default=default)


def bound(parameters: list[str]) -> dict[str, str]:
    """Return what replaces each name in texts such as ``A=ball``.

    Raises:
        BadParameter: if a text has another form.
    """
    replaced = {}
    for text in parameters:
        name, equals, target = text.partition("=")
        if not (name and equals and target):
            raise typer.BadParameter(f'"{text}" is not NAME=TARGET, such as A=ball')
        replaced[name] = target
    return replaced
